/// The six directions of a voxel's faces: −x, +x, −y, +y, −z, +z.
export const directions = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/// Faces between a voxel that is shown and what is not: the voxel (its place in `index`) and the direction. kept: a byte
/// a voxel, or null where all are shown.
export function voxel_faces({grid, index: indices}, kept = null) {
  const [nx, ny, nz] = grid.size;
  const shown = new Uint8Array(nx * ny * nz);
  for (let k = 0; k < indices.length; ++k) if (!kept || kept[k]) shown[indices[k]] = 1;
  const voxels = [];
  const sides = [];
  const add_unless = (covered, voxel, side) => {
    if (covered) return;
    voxels.push(voxel);
    sides.push(side);
  };
  for (let k = 0; k < indices.length; ++k) {
    const at = indices[k];
    if (!shown[at]) continue;
    const x = at % nx, y = Math.floor(at / nx) % ny, z = Math.floor(at / (nx * ny));
    add_unless(x > 0 && shown[at - 1], k, 0);
    add_unless(x < nx - 1 && shown[at + 1], k, 1);
    add_unless(y > 0 && shown[at - nx], k, 2);
    add_unless(y < ny - 1 && shown[at + nx], k, 3);
    add_unless(z > 0 && shown[at - nx * ny], k, 4);
    add_unless(z < nz - 1 && shown[at + nx * ny], k, 5);
  }
  return {face_voxel: Int32Array.from(voxels), face_direction: Uint8Array.from(sides)};
}
