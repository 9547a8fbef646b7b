import {TriangleList, apply_scale, solid_material} from './shading.js';
import {directions, voxel_faces} from './voxel_faces.js';
import {plane_in} from './clip_plane.js';
import {same} from '../state/store.js';

// Corners of the face in each direction, anticlockwise from outside.
const face_corners = directions.map((normal, d) => {
  const axis = d >> 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
  const square = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([s, t]) => {
    const corner = [0, 0, 0];
    corner[axis] = normal[axis], corner[u] = s, corner[v] = t;
    return corner.map(x => x / 2);
  });
  return normal[axis] > 0 ? square : square.reverse();
});

const two_triangles = [0, 1, 2, 2, 3, 0];

/// The pseudo volume's voxels, as the faces between inside and outside.
export class VoxelLayer {
  constructor(viewport) {
    this.viewport = viewport;
    this.list = new TriangleList(solid_material({edges: 0.18, quads: true, color: '#7d93b8'}));
    viewport.model.add(this.list.mesh);
    this.show(false);
  }

  show(on) {
    this.list.mesh.visible = on;
  }

  /// voxels: the document of /voxels with its faces (see data_worker.js).
  set_voxels(voxels) {
    this.voxels = voxels;
    this.drawn = null;
  }

  /// values: a number a voxel, with its scale; selected: a byte a voxel, or null for all.
  update({plane, values, scale, edges_only, selected}) {
    if (!this.voxels) return;
    const wanted = {plane: plane && plane_in(plane, this.viewport.model.matrix), values, selected};
    if (!this.drawn || Object.keys(wanted).some(key => key === 'plane' ? !same(wanted.plane, this.drawn.plane) : wanted[key] !== this.drawn[key]))
      this.draw(wanted);
    const {material} = this.list.mesh;
    apply_scale(material, scale);
    material.uniforms.edges_only.value = edges_only;
    material.transparent = edges_only;
    this.viewport.invalidate();
  }

  draw(wanted) {
    const {plane, values, selected} = this.drawn = wanted;
    const kept = this.kept_voxels(plane, selected);
    const {face_voxel, face_direction} = kept ? voxel_faces(this.voxels, kept) : this.voxels;
    this.shown_voxels = face_voxel;
    this.list.reserve(2 * face_voxel.length);
    this.write_faces(face_voxel, face_direction, values);
    this.list.upload(2 * face_voxel.length);
  }

  center(voxel) {
    const {origin, spacing, size: [nx, ny]} = this.voxels.grid;
    const at = this.voxels.index[voxel];
    return [origin[0] + (at % nx + 0.5) * spacing, origin[1] + (Math.floor(at / nx) % ny + 0.5) * spacing,
      origin[2] + (Math.floor(at / (nx * ny)) + 0.5) * spacing];
  }

  /// Those on the kept side of the plane that are selected; null for all.
  kept_voxels(plane, selected) {
    if (!plane) return selected;
    const kept = new Uint8Array(this.voxels.index.length);
    for (let voxel = 0; voxel < kept.length; ++voxel) {
      if (selected && !selected[voxel]) continue;
      const [x, y, z] = this.center(voxel);
      if (plane[0] * x + plane[1] * y + plane[2] * z <= plane[3]) kept[voxel] = 1;
    }
    return kept;
  }

  write_faces(face_voxel, face_direction, values) {
    const {spacing} = this.voxels.grid, {positions} = this.list;
    for (let k = 0, to = 0; k < face_voxel.length; ++k) {
      const center = this.center(face_voxel[k]), corners = face_corners[face_direction[k]];
      for (const corner of two_triangles)
        for (let axis = 0; axis < 3; ++axis) positions[to++] = center[axis] + spacing * corners[corner][axis];
      this.list.values.fill(values ? values[face_voxel[k]] : 0, 6 * k, 6 * k + 6);
    }
  }
}
