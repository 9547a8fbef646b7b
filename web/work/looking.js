import * as THREE from 'three';
import {clip_plane} from '../view/clip_plane.js';
import {grid_ink, grid_mesh} from '../view/collider_mesh.js';
import {Highlight} from '../view/highlight.js';
import {scene_bounds, with_ground} from '../view/scene_bounds.js';
import {SimLayer} from '../view/sim_layer.js';
import {SurfaceLayer} from '../view/surface_layer.js';
import {TetLayer} from '../view/tet_layer.js';
import {VoxelLayer} from '../view/voxel_layer.js';
import {make_selection, sim_coloring, tet_coloring, voxel_coloring} from '../view/coloring.js';
import {once_a_frame} from '../ui/dom.js';
import {theme_color} from '../ui/theme.js';

// Around the surface, as a share of its box's diagonal.
const least_room = 0.03;

/// Brings the state's view, the model and the simulation onto the screen: which layers, where, in which colours.
/// `legend` is the colouring that the inspector explains. Events: coloring (the legend or its selection changed).
export class Looking extends EventTarget {
  constructor(app) {
    super();
    const {store, viewport, meshing, simulation} = Object.assign(this, app);
    this.run = action => app.run(action);
    this.surface = new SurfaceLayer(viewport, viewport.model);
    this.voxels = new VoxelLayer(viewport);
    this.tets = new TetLayer(viewport);
    this.sim = new SimLayer(viewport);
    this.highlight = new Highlight(viewport);
    this.room = least_room;
    this.grid = grid_mesh();
    this.grid.rotation.x = -Math.PI / 2;
    viewport.scene.add(this.grid);
    const soon = once_a_frame(() => this.update());
    meshing.addEventListener('mesh', () => (viewport.mark(null), this.room = least_room, this.place()));
    meshing.addEventListener('geometry', () => this.show_geometry());
    meshing.addEventListener('model', () => this.show_cells());
    meshing.addEventListener('voxels', () => (this.voxels.set_voxels(meshing.voxels), this.update()));
    viewport.addEventListener('picture', ({detail}) => meshing.pace(detail));
    simulation.addEventListener('bodies', () => (this.sim.set_bodies(simulation.bodies), this.place()));
    simulation.addEventListener('frame', once_a_frame(() => this.show_frame()));
    store.on(['view.layers', 'view.clip', 'view.explode', 'view.edges_only', 'view.color_by', 'view.voxel_color',
      'view.select', 'view.sim_look'], soon);
    store.on('scene', () => this.place());
  }

  /// The mesh stands where the scene's body starts.
  place() {
    this.set_bounds();
    this.update();
  }

  set_bounds() {
    const scene = this.store.get('scene');
    const report = this.meshing.mesh?.report;
    if (!scene || !report) return;
    const {viewport} = this;
    const body = scene.bodies.find(({mesh}) => mesh === 'current');
    const box = scene_bounds(scene);
    if (body) box.union(this.place_model(body, report.bounds));
    else box.union(this.sim.bounds());  // meshes of files
    this.bodies_bounds = box;
    const room = body ? this.room * this.model_bounds.getSize(new THREE.Vector3()).length() : 0;
    const {min, max} = with_ground(box.clone().expandByScalar(room), scene);
    viewport.set_bounds(min.toArray(), max.toArray());
  }

  place_model(body, bounds) {
    const {viewport} = this;
    viewport.model.matrix.compose(new THREE.Vector3(...body.position), new THREE.Quaternion(...body.orientation), new THREE.Vector3().setScalar(body.scale));
    const box = new THREE.Box3(new THREE.Vector3(...bounds.min), new THREE.Vector3(...bounds.max));
    this.model_bounds = box.applyMatrix4(viewport.model.matrix);
    viewport.model.matrix.multiply(new THREE.Matrix4().makeTranslation(...this.meshing.origin));
    viewport.model.updateMatrixWorld(true);
    return this.model_bounds;
  }

  mark_picked(hit) {
    const {highlight, meshing} = this;
    highlight.clear();
    if (hit?.kind === 'cell') highlight.show_cell(meshing.cells, hit.cell);
    if (hit?.kind === 'voxel') highlight.show_box(hit.point_in_model, meshing.voxels.grid.spacing);
  }

  show_ray({positions}) {
    this.highlight.show_ray(positions);
  }

  show_geometry() {
    const {positions, triangles} = this.meshing.geometry;
    this.surface.set_triangles(positions, triangles);
    this.place();
  }

  show_cells() {
    const {meshing} = this;
    this.highlight.clear();
    this.tets.set_cells(meshing.cells);
    if (!meshing.preview) this.make_room();
    this.update(true);
  }

  /// Tets reach beyond the surface. In steps, so that the view rarely moves for them.
  make_room() {
    const {mesh: {report: {bounds}}, origin, cells} = this.meshing;
    const surface = new THREE.Box3(new THREE.Vector3(...bounds.min), new THREE.Vector3(...bounds.max));
    const diagonal = surface.getSize(new THREE.Vector3()).length();
    const tets = new THREE.Box3().setFromArray(cells.positions).translate(new THREE.Vector3(...origin));
    const beyond = Math.max(...surface.min.sub(tets.min), ...tets.max.sub(surface.max));
    const room = least_room * Math.max(1, Math.ceil(beyond / diagonal / least_room));
    if (room === this.room) return;
    this.room = room;
    this.set_bounds();
  }

  show_frame() {
    if (!this.simulation.shown) return;
    this.sim.set_frame(this.simulation.shown);
    if (this.store.get('view.color_by') === 'volume_error') this.update();
  }

  /// at_once: before the panels are written, so that the graphics processor works meanwhile.
  update(at_once = false) {
    const view = this.store.get('view');
    const {layers} = view;
    grid_ink.value.set(theme_color('--grid'));
    const plane = this.plane = clip_plane(view.clip, this.model_bounds ?? this.viewport.bounds);
    const solid = layers.tets || layers.voxels;
    if ((layers.voxels || view.color_by === 'density') && this.meshing.model && !this.meshing.voxels) this.run(() => this.meshing.load_voxels());
    this.surface.show(layers.surface && Boolean(this.meshing.geometry));
    // What a slider changes comes first: without a graphics processor the surface takes longer than a preview's tets.
    this.surface.update({plane: solid ? null : plane, edges_only: view.edges_only, glass: view.surface_look === 'glass' && this.shows_inside(layers),
      fine: this.meshing.preview === true && layers.tets});
    this.coloring = this.same_coloring(view) ?? tet_coloring(view.color_by, this.meshing, this.sim);
    this.voxel_colors = this.voxel_coloring(view);
    this.sim_colors = layers.sim && view.sim_look === 'cells' ? sim_coloring(view.color_by, this.coloring, this.sim) : null;
    this.legend = this.explained(layers);
    this.update_tets(view, plane);
    this.update_voxels(view, plane);
    this.sim.show(layers.sim);
    this.highlight.show(solid || layers.surface);  // what was picked of the model is nowhere in a run
    this.sim.update({look: view.sim_look, coloring: this.sim_colors, errors: view.color_by === 'volume_error',
      selected: this.sim_colors && this.selection(view.select, this.sim_colors, 5), edges_only: view.edges_only});
    if (at_once) this.viewport.draw();
    else this.viewport.invalidate();
    this.tell_coloring(view);
  }

  explained({tets, voxels}) {
    if (tets) return this.coloring;
    return voxels && this.voxel_colors?.values ? this.voxel_colors : this.sim_colors ?? this.coloring;
  }

  /// Colours that did not change keep their arrays, so that nothing is drawn anew for them.
  same_coloring({color_by}) {
    const of = this.colored;
    const still = of && color_by !== 'volume_error' && of.color_by === color_by && of.cells === this.meshing.cells && of.voxels === this.meshing.voxels;
    this.colored = {color_by, cells: this.meshing.cells, voxels: this.meshing.voxels};
    return still ? this.coloring : null;
  }

  voxel_coloring({voxel_color}) {
    const {voxels} = this.meshing, of = this.voxel_colored;
    if (of && of.voxel_color === voxel_color && of.voxels === voxels) return this.voxel_colors;
    this.voxel_colored = {voxel_color, voxels};
    return voxels && voxel_coloring(voxel_color, voxels);
  }

  tell_coloring({select}) {
    if (this.told?.legend === this.legend && this.told.select === JSON.stringify(select)) return;
    this.told = {legend: this.legend, select: JSON.stringify(select)};
    this.dispatchEvent(new Event('coloring'));
  }

  /// Something stands behind the glass.
  shows_inside({tets, voxels}) {
    return Boolean(tets && this.meshing.cells || voxels && this.meshing.voxels);
  }

  update_tets(view, plane) {
    const shown = view.layers.tets && Boolean(this.meshing.cells);
    this.tets.show(shown);
    if (!shown) return;
    this.tets.update({plane, cut: view.clip.mode === 'cut', explode: view.explode, selected: this.selection(view.select, this.coloring, 5),
      values: this.coloring.values, scale: this.coloring.scale, edges_only: view.edges_only});
  }

  /// What the legend's range selects of its own kind; kept while neither changes.
  selection(range, coloring, group) {
    if (coloring !== this.legend) return null;
    const of = JSON.stringify(range);
    if (this.selected_of?.range !== of || this.selected_of.coloring !== coloring)
      this.selected_of = {range: of, coloring, selected: make_selection(range, coloring, group)};
    return this.selected_of.selected;
  }

  update_voxels(view, plane) {
    const shown = view.layers.voxels && Boolean(this.meshing.voxels);
    this.voxels.show(shown);
    if (shown) this.voxels.update({plane, edges_only: view.edges_only, ...this.voxel_colors, selected: this.selection(view.select, this.voxel_colors, 1)});
  }
}
