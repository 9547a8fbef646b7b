import * as THREE from 'three';
import {TriangleList, apply_scale, no_clip, solid_material} from './shading.js';
import {tet_faces, tet_of_face} from './cell_topology.js';
import {at_edge, draw_cells, hidden, move_cells} from './cell_faces.js';
import {SurfaceLayer} from './surface_layer.js';
import {collider_mesh} from './collider_mesh.js';
import {indexed, raycast} from './raycast.js';
import {apply_embedding, cell_volumes, finite_weights, inverted_tets} from './deformation.js';

/// The bodies of a simulation at the frame shown: skins moved by the embedding, cells, rigid shapes, inverted tets.
export class SimLayer {
  constructor(viewport) {
    this.viewport = viewport;
    this.group = new THREE.Group();
    viewport.scene.add(this.group);
    this.bodies = new Map();
    this.options = {look: 'skin', coloring: null, errors: false, selected: null, edges_only: false};
    this.show(false);
  }

  show(on) {
    this.group.visible = on;
  }

  set_bodies(bodies) {
    for (const view of this.bodies.values()) view.dispose();
    this.bodies.clear();
    this.frame = null;  // of other bodies
    for (const body of bodies)
      this.bodies.set(body.id, body.type === 'deformable' ? new DeformableView(this, body) : new RigidView(this, body));
    let cells = 0;
    for (const view of this.views()) if (view.rest_volumes) view.first_cell = cells, cells += view.rest_volumes.length;
  }

  /// look: 'skin' or 'cells'; coloring: of the cells, errors: by their errors, those of one body after the other; selected:
  /// a byte a cell of the coloring, or null for all.
  update(options) {
    this.options = options;
    for (const view of this.bodies.values()) view.restyle?.();
    if (this.frame) this.set_frame(this.frame);
    this.viewport.invalidate();
  }

  set_frame(frame) {
    this.frame = frame;
    for (const body of frame.bodies) this.bodies.get(body.id)?.set_frame(body, frame.metrics);
    this.viewport.invalidate();
  }

  /// Where the deformable bodies start.
  bounds() {
    const box = new THREE.Box3();
    for (const {body} of this.views()) if (body.type === 'deformable') box.union(new THREE.Box3().setFromArray(body.rest_positions));
    return box;
  }

  views() {
    return [...this.bodies.values()];
  }
}

class DeformableView {
  constructor(layer, body) {
    Object.assign(this, {layer, body, positions: Float32Array.from(body.rest_positions)});
    this.rest_volumes = cell_volumes(this.positions, body.tets);
    this.cells = {positions: this.positions, tets: body.tets, neighbour: body.neighbour};
    this.list = new TriangleList(solid_material({color: '#b9a88c', edges: 0.35}));
    this.inverted = new TriangleList(solid_material({color: '#ff1a4d', edges: 0.5}));
    this.inverted.mesh.renderOrder = 2;
    this.inverted.mesh.material.depthTest = false;
    draw_cells(this.list, this.cells);
    layer.group.add(this.list.mesh, this.inverted.mesh);
    if (body.embedded) this.make_skin(body.embedded);
    this.restyle();
  }

  make_skin({triangles, tet, weights}) {
    finite_weights(weights);
    this.skin = new SurfaceLayer(this.layer.viewport, this.layer.group);
    this.skin.set_triangles(new Float32Array(3 * tet.length), triangles);
    this.move_skin();
  }

  move_skin() {
    apply_embedding(this.body.embedded, this.body.tets, this.positions, this.skin.positions);
    this.skin.moved();
  }

  get shows_cells() {
    return this.layer.options.look === 'cells' || !this.skin;
  }

  restyle() {
    const {coloring, edges_only} = this.layer.options;
    this.skin?.show(!this.shows_cells);
    this.skin?.update({edges_only});
    this.list.mesh.visible = this.shows_cells;
    const {material} = this.list.mesh;
    apply_scale(material, this.tet_values() && coloring.scale);
    material.uniforms.edges_only.value = edges_only;
    material.uniforms.clip.value = no_clip;
    material.transparent = edges_only;
  }

  set_frame({positions}, metrics) {
    this.cells.positions = this.positions = positions;
    if (this.shows_cells) {
      this.draw();
    } else {
      this.move_skin();
    }
    if (metrics.inverted > 0 || this.inverted.triangles > 0) this.draw_inverted();
  }

  draw() {
    const values = this.tet_values(), visible = this.visible_cells();
    if (visible || this.partial) draw_cells(this.list, this.cells, {visible, values});
    else move_cells(this.list, this.cells, values);
    this.partial = Boolean(visible);
  }

  visible_cells() {
    const {selected, errors, coloring} = this.layer.options;
    if (!selected || !errors && !this.has_tets_of(coloring.values)) return null;
    const first = errors ? this.first_cell : 0;
    return selected.slice(first, first + this.rest_volumes.length).map(shown => shown ? at_edge : hidden);
  }

  /// values: one a tet of a model.
  has_tets_of(values) {
    return 4 * values.length === this.body.tets.length;
  }

  /// What the cells are coloured by, or null.
  tet_values() {
    const {coloring, errors} = this.layer.options;
    if (!this.shows_cells || !coloring?.values) return null;
    if (errors) return this.errors_per_tet();
    return this.has_tets_of(coloring.values) ? coloring.values : null;
  }

  errors_per_tet() {
    const volumes = cell_volumes(this.positions, this.body.tets);
    const errors = new Float32Array(5 * volumes.length);
    volumes.forEach((volume, cell) => errors.fill(Math.abs(volume - this.rest_volumes[cell]) / this.rest_volumes[cell], 5 * cell, 5 * cell + 5));
    return errors;
  }

  draw_inverted() {
    const {tets} = this.body;
    const bad = inverted_tets(this.positions, tets);
    this.inverted.reserve(4 * bad.length);
    bad.forEach((tet, k) => tet_faces.forEach((face, f) => face.forEach((corner, c) => {
      const from = 3 * tets[4 * tet + corner];
      this.inverted.positions.set(this.positions.subarray(from, from + 3), 36 * k + 9 * f + 3 * c);
    })));
    this.inverted.upload(4 * bad.length);
  }

  /// The hit with what is drawn, and the particle nearest to it.
  raycast(ray) {
    const hit = raycast(this.shows_cells ? this.list : indexed(this.skin), ray);
    return hit && {...hit, vertex: this.nearest_vertex(hit)};
  }

  nearest_vertex({triangle, point}) {
    const {tets, embedded} = this.body;
    const face = this.shows_cells ? this.list.faces[triangle] : -1;
    const tet = face >= 0 ? tet_of_face(face) : embedded.tet[embedded.triangles[3 * triangle]];
    const distance = v => [0, 1, 2].reduce((sum, axis) => sum + (this.positions[3 * v + axis] - point[axis]) ** 2, 0);
    return [...tets.subarray(4 * tet, 4 * tet + 4)].sort((a, b) => distance(a) - distance(b))[0];
  }

  dispose() {
    this.layer.group.remove(this.list.mesh, this.inverted.mesh);
    this.list.dispose();
    this.inverted.dispose();
    this.skin?.dispose();
  }
}

class RigidView {
  constructor(layer, body) {
    Object.assign(this, {layer, body});
    this.object = collider_mesh(body);
    layer.group.add(this.object);
  }

  raycast(ray) {
    if (!this.pose) return null;
    this.object.updateMatrixWorld();
    const [hit] = new THREE.Raycaster(ray.origin, ray.direction).intersectObject(this.object);
    return hit ? {distance: hit.distance, point: hit.point.toArray()} : null;
  }

  set_frame({pose}) {
    if (!pose) return;
    this.pose = pose;
    this.object.position.set(...pose.slice(0, 3));
    this.object.quaternion.set(...pose.slice(3));
  }

  dispose() {
    this.layer.group.remove(this.object);
    this.object.traverse(child => (child.geometry?.dispose(), child.material?.dispose()));
  }
}
