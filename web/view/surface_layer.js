import {TriangleList, no_clip, solid_material} from './shading.js';

/// A triangle mesh as it was given; also the simulation's skin, whose vertices move.
export class SurfaceLayer {
  constructor(viewport, parent, {color = '#c8b79c'} = {}) {
    this.viewport = viewport;
    this.parent = parent;
    this.list = new TriangleList(solid_material({color, edges: 0}));
    parent.add(this.list.mesh);
    this.show(false);
  }

  show(on) {
    this.list.mesh.visible = on;
  }

  set_triangles(positions, triangles) {
    this.triangles = triangles;
    this.list.reserve(triangles.length / 3);
    this.move(positions);
  }

  move(positions) {
    const {triangles, list} = this;
    for (let i = 0; i < triangles.length; ++i) {
      const from = 3 * triangles[i], to = 3 * i;
      list.positions[to] = positions[from];
      list.positions[to + 1] = positions[from + 1];
      list.positions[to + 2] = positions[from + 2];
    }
    list.upload(triangles.length / 3);
    this.viewport.invalidate();
  }

  update({plane = null, edges_only = false, color}) {
    const {material} = this.list.mesh;
    material.uniforms.clip.value = plane ?? no_clip;
    material.uniforms.edges_only.value = edges_only;
    material.uniforms.edge_strength.value = edges_only ? 0.8 : 0;
    material.transparent = edges_only;
    if (color) material.uniforms.base.value.set(color);
    this.viewport.invalidate();
  }

  dispose() {
    this.parent.remove(this.list.mesh);
    this.list.dispose();
  }
}
