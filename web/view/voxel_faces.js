/// The six directions of a voxel's faces: −x, +x, −y, +y, −z, +z.
export const directions = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/// Faces between an inside voxel and an outside one: the inside voxel (its place in `index`) and the direction.
/// The mask `inside` over the grid serves clipping, which exposes further faces.
export function voxel_faces({grid, index: indices}) {
  const [nx, ny, nz] = grid.size;
  const inside = new Uint8Array(nx * ny * nz);
  for (const at of indices) inside[at] = 1;
  const steps = [-1, 1, -nx, nx, -nx * ny, nx * ny];
  const voxels = [];
  const sides = [];
  indices.forEach((at, k) => {
    const x = at % nx, y = Math.floor(at / nx) % ny, z = Math.floor(at / (nx * ny));
    const on_border = [x === 0, x === nx - 1, y === 0, y === ny - 1, z === 0, z === nz - 1];
    for (let d = 0; d < 6; ++d) {
      if (!on_border[d] && inside[at + steps[d]]) continue;
      voxels.push(k);
      sides.push(d);
    }
  });
  return {face_voxel: Int32Array.from(voxels), face_direction: Uint8Array.from(sides), inside};
}
