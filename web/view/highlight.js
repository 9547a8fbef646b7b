import * as THREE from 'three';
import {face_corners, faces_per_cell} from './cell_topology.js';

const line_material = color => new THREE.LineBasicMaterial({color, depthTest: false, transparent: true});

/// Outlines of what was picked and the ray through it, drawn over everything, in the mesh's own coordinates.
export class Highlight {
  constructor(viewport) {
    this.viewport = viewport;
    this.group = new THREE.Group();
    viewport.model.add(this.group);
    this.outline = this.add(new THREE.LineSegments(new THREE.BufferGeometry(), line_material('#ffffff')));
    this.ray = this.add(new THREE.Line(new THREE.BufferGeometry(), line_material('#ffb454')));
  }

  add(object) {
    object.renderOrder = 4;
    object.frustumCulled = false;
    object.visible = false;
    this.group.add(object);
    return object;
  }

  show(on) {
    this.group.visible = on;
  }

  /// The twelve triangles of a cell.
  show_cell({positions, tets}, cell) {
    const points = [];
    const point = corner => {
      const vertex = tets[20 * cell + face_corners[corner]];
      return positions.subarray(3 * vertex, 3 * vertex + 3);
    };
    for (let face = 0; face < faces_per_cell; ++face)
      for (let corner = 0; corner < 3; ++corner) points.push(...point(3 * face + corner), ...point(3 * face + (corner + 1) % 3));
    this.set(this.outline, points);
  }

  show_box(center, size) {
    const box = new THREE.EdgesGeometry(new THREE.BoxGeometry(size, size, size)).translate(...center);
    this.set(this.outline, [...box.attributes.position.array]);
  }

  show_ray(positions) {
    this.set(this.ray, positions.length ? [...positions.subarray(0, 3), ...positions.subarray(positions.length - 3)] : []);
  }

  clear() {
    this.set(this.outline, []);
    this.set(this.ray, []);
  }

  set(object, points) {
    object.visible = points.length > 0;
    object.geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
    this.viewport.invalidate();
  }
}
