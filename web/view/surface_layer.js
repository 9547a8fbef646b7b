import * as THREE from 'three';
import {theme_color} from '../ui/theme.js';
import {fine_layer} from './viewport.js';
import {apply_orthographic, no_clip, solid_material} from './shading.js';

/// A triangle mesh as it was given; also the simulation's skin, whose vertices move. As glass it is drawn in two
/// passes: depth alone, then only the nearest layer, lit at its rims.
export class SurfaceLayer {
  constructor(viewport, parent) {
    Object.assign(this, {viewport, parent, triangles: new Uint32Array(), positions: new Float32Array()});
    this.geometry = new THREE.BufferGeometry();
    this.geometry.boundingSphere = new THREE.Sphere();
    this.material = solid_material({edges: 0});
    this.depth_material = new THREE.MeshBasicMaterial({colorWrite: false, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2});
    this.mesh = this.add(this.material, 2);
    this.depth = this.add(this.depth_material, 1);
    apply_orthographic(this.mesh);
    this.show(false);
  }

  add(material, order) {
    const mesh = new THREE.Mesh(this.geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = order;
    this.parent.add(mesh);
    return mesh;
  }

  show(on) {
    this.on = this.mesh.visible = on;
    this.depth.visible = on && this.glass === true;
  }

  set_triangles(positions, triangles) {
    this.triangles = triangles;
    this.geometry.dispose();
    this.geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(triangles), 1));
    this.geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(positions), 3).setUsage(THREE.DynamicDrawUsage));
    this.positions = this.geometry.attributes.position.array;
    this.viewport.invalidate();
  }

  /// After the positions were written.
  moved() {
    this.geometry.attributes.position.needsUpdate = true;
    this.viewport.invalidate();
  }

  /// fine: drawn only when the picture is sharp.
  update({plane = null, edges_only = false, glass = false, fine = false}) {
    this.glass = glass && !edges_only;
    const {uniforms} = this.material;
    uniforms.clip.value = plane ?? no_clip;
    uniforms.base.value.set(theme_color('--surface-color'));
    uniforms.glass.value = this.glass;
    this.material.wireframe = edges_only;
    this.material.transparent = this.glass;
    // Glass is drawn twice over what stands behind it: not while a slow picture moves.
    for (const mesh of [this.mesh, this.depth]) mesh.layers.set(this.glass || fine ? fine_layer : 0);
    this.show(this.on);
    this.viewport.invalidate();
  }

  dispose() {
    this.parent.remove(this.mesh, this.depth);
    for (const made of [this.geometry, this.material, this.depth_material]) made.dispose();
  }
}
