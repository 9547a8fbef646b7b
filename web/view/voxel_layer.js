import {TriangleList, apply_scale, solid_material} from './shading.js';
import {directions} from './voxel_faces.js';
import {plane_in} from './clip_plane.js';

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
  }

  /// values: a number an inside voxel, with its scale.
  update({plane, values, scale, edges_only}) {
    if (!this.voxels) return;
    const local = plane ? plane_in(plane, this.viewport.model.matrix) : null;
    const faces = this.visible_faces(local);
    this.shown_voxels = Int32Array.from(faces, ([voxel]) => voxel);
    this.list.reserve(2 * faces.length);
    faces.forEach(([voxel, direction], k) => this.write_face(k, voxel, direction, values));
    this.list.upload(2 * faces.length);
    const {material} = this.list.mesh;
    apply_scale(material, scale);
    material.uniforms.edges_only.value = edges_only;
    material.transparent = edges_only;
    this.viewport.invalidate();
  }

  center(voxel) {
    const {origin, spacing, size: [nx, ny]} = this.voxels.grid;
    const at = this.voxels.index[voxel];
    const coord = [at % nx, Math.floor(at / nx) % ny, Math.floor(at / (nx * ny))];
    return coord.map((i, axis) => origin[axis] + (i + 0.5) * spacing);
  }

  /// Faces of the boundary on the kept side, and those that the plane exposes.
  visible_faces(plane) {
    const {face_voxel, face_direction, index, inside, grid} = this.voxels;
    const faces = [];
    const depth = voxel => {
      const c = this.center(voxel);
      return plane[0] * c[0] + plane[1] * c[1] + plane[2] * c[2] - plane[3];
    };
    for (let k = 0; k < face_voxel.length; ++k)
      if (!plane || depth(face_voxel[k]) <= 0) faces.push([face_voxel[k], face_direction[k]]);
    if (!plane) return faces;
    const {spacing, size: [nx, ny]} = grid;
    const steps = [-1, 1, -nx, nx, -nx * ny, nx * ny];
    for (let voxel = 0; voxel < index.length; ++voxel) {
      const d = depth(voxel);
      if (d > 0 || d < -2 * spacing) continue;
      directions.forEach((n, side) => {
        const beyond = d + spacing * (plane[0] * n[0] + plane[1] * n[1] + plane[2] * n[2]) > 0;
        if (beyond && inside[index[voxel] + steps[side]]) faces.push([voxel, side]);
      });
    }
    return faces;
  }

  write_face(k, voxel, direction, values) {
    const center = this.center(voxel), {spacing} = this.voxels.grid;
    const corners = face_corners[direction];
    [0, 1, 2, 2, 3, 0].forEach((corner, i) => {
      for (let axis = 0; axis < 3; ++axis)
        this.list.positions[18 * k + 3 * i + axis] = center[axis] + spacing * corners[corner][axis];
    });
    this.list.values.fill(values ? values[voxel] : 0, 6 * k, 6 * k + 6);
  }
}
