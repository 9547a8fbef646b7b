import * as THREE from 'three';
import {TriangleList, apply_scale, no_clip, solid_material} from './shading.js';
import {at_edge, draw_cells, seen} from './cell_faces.js';
import {draw_cut} from './cut.js';
import {plane_in} from './clip_plane.js';
import {same} from '../state/store.js';

/// The model's tets: what is visible of its cells after clipping, selection and exploding, and the cut surface.
export class TetLayer {
  constructor(viewport) {
    this.viewport = viewport;
    this.faces = new TriangleList(solid_material({edges: 0.35}));
    this.cut = new TriangleList(solid_material({edges: 0.35, quads: true}));
    this.lists = [this.faces, this.cut];
    for (const list of this.lists) viewport.model.add(list.mesh);
    this.cells = null;
    this.show(false);
  }

  show(on) {
    for (const list of this.lists) list.mesh.visible = on;
  }

  /// cells: the documents of /tets and /quality with the neighbours and centres (see data_worker.js).
  set_cells(cells) {
    this.cells = cells;
    this.centers = cells.centers;
    this.drawn = null;
  }

  /// plane: clip in the world or null; cut: slice cells instead of keeping whole ones; selected: a byte a cell or
  /// null; values: a number a tet with its scale.
  update({plane, cut, explode, selected, values, scale, edges_only}) {
    const local = plane ? plane_in(plane, this.viewport.model.matrix) : null;
    const sliced = Boolean(local && cut && explode === 0);
    const wanted = {local, sliced, exploded: explode > 0, selected, values};
    if (!this.drawn || Object.keys(wanted).some(key => key === 'local' ? !same(wanted.local, this.drawn.local) : wanted[key] !== this.drawn[key]))
      this.draw(wanted);
    const {uniforms} = this.faces.mesh.material;
    uniforms.explode.value = this.faces.explode = explode;
    uniforms.middle.value.set(...this.centers.middle);
    uniforms.clip.value = sliced ? plane : no_clip;
    for (const {mesh: {material}} of this.lists) restyle(material, scale, edges_only);
    this.faces.mesh.material.side = edges_only ? THREE.DoubleSide : THREE.FrontSide;  // they enclose the cells
    this.viewport.invalidate();
  }

  draw(wanted) {
    const {local, sliced, exploded, selected, values} = this.drawn = wanted;
    const visible = this.visible_cells(sliced ? null : local, selected);
    draw_cells(this.faces, this.cells, {visible, values, centers: exploded ? this.centers : null});
    if (sliced) draw_cut(this.cut, this.cells, local, {visible, values});
    else this.cut.upload_none();
  }

  visible_cells(plane, selected) {
    if (!plane && !selected) return null;
    const {cells} = this.centers;
    const visible = new Uint8Array(cells.length / 3);
    const [nx, ny, nz, w] = plane ?? [0, 0, 0, 1];
    const reach = 2 * this.cells.grid.spacing;  // a neighbour's centre, with room for smoothing
    for (let cell = 0, at = 0; cell < visible.length; ++cell, at += 3) {
      const depth = nx * cells[at] + ny * cells[at + 1] + nz * cells[at + 2] - w;
      if (depth > 0 || selected && !selected[cell]) continue;
      visible[cell] = selected || depth > -reach ? at_edge : seen;
    }
    return visible;
  }
}

function restyle(material, scale, edges_only) {
  apply_scale(material, scale);
  material.uniforms.edges_only.value = edges_only;
  material.transparent = edges_only;
  material.uniforms.edge_strength.value = edges_only ? 0.9 : 0.35;
}
