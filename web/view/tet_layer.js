import {TriangleList, apply_scale, no_clip, solid_material} from './shading.js';
import {cell_centers, draw_cells} from './cell_faces.js';
import {draw_cut} from './cut.js';
import {plane_in} from './clip_plane.js';

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

  /// cells: the document of /tets with its topology (see data_worker.js).
  set_cells(cells) {
    this.cells = cells;
    this.centers = cell_centers(cells);
  }

  /// plane: clip in the world or null; cut: slice cells instead of keeping whole ones; selected: a byte a cell or
  /// null; values: a number a tet with its scale.
  update({plane, cut, explode, selected, values, scale, edges_only}) {
    if (!this.cells) return;
    const local = plane ? plane_in(plane, this.viewport.model.matrix) : null;
    const sliced = local && cut && explode === 0;
    this.visible = this.visible_cells(sliced ? null : local, selected);
    draw_cells(this.faces, this.cells, {visible: this.visible, values, explode, centers: this.centers});
    if (sliced) draw_cut(this.cut, this.cells, local, {visible: this.visible, values});
    else this.cut.upload_none();
    this.faces.mesh.material.uniforms.clip.value = sliced ? plane : no_clip;
    for (const {mesh: {material}} of this.lists) {
      apply_scale(material, scale);
      material.uniforms.edges_only.value = edges_only;
      material.transparent = edges_only;
      material.uniforms.edge_strength.value = edges_only ? 0.9 : 0.35;
    }
    this.viewport.invalidate();
  }

  visible_cells(plane, selected) {
    if (!plane && !selected) return null;
    const {cells} = this.centers;
    const visible = new Uint8Array(cells.length / 3);
    for (let cell = 0; cell < visible.length; ++cell) {
      if (selected && !selected[cell]) continue;
      const at = 3 * cell;
      visible[cell] = !plane || plane[0] * cells[at] + plane[1] * cells[at + 1] + plane[2] * cells[at + 2] <= plane[3];
    }
    return visible;
  }
}
