/// Nearest hit of a ray {origin, direction} with triangles in its own coordinates: {triangle, distance, point}, or
/// null. at(triangle, corner): where its coordinates begin in `positions`. plane [nx, ny, nz, w]: what lies beyond it
/// is cut away.
export function raycast({positions: p, triangles, at = plain}, ray, plane = null) {
  const {x: ox, y: oy, z: oz} = ray.origin, {x: dx, y: dy, z: dz} = ray.direction;
  let nearest = Infinity, triangle = -1;
  for (let k = 0; k < triangles; ++k) {
    const a = at(k, 0), b = at(k, 1), c = at(k, 2);
    // Möller & Trumbore 1997
    const ex = p[b] - p[a], ey = p[b + 1] - p[a + 1], ez = p[b + 2] - p[a + 2];
    const fx = p[c] - p[a], fy = p[c + 1] - p[a + 1], fz = p[c + 2] - p[a + 2];
    const hx = dy * fz - dz * fy, hy = dz * fx - dx * fz, hz = dx * fy - dy * fx;
    const det = ex * hx + ey * hy + ez * hz;
    if (Math.abs(det) < 1e-20) continue;
    const sx = ox - p[a], sy = oy - p[a + 1], sz = oz - p[a + 2];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < 0 || u > 1) continue;
    const qx = sy * ez - sz * ey, qy = sz * ex - sx * ez, qz = sx * ey - sy * ex;
    const v = (dx * qx + dy * qy + dz * qz) / det;
    if (v < 0 || u + v > 1) continue;
    const t = (fx * qx + fy * qy + fz * qz) / det;
    if (t <= 0 || t >= nearest) continue;
    if (plane && plane[0] * (ox + t * dx) + plane[1] * (oy + t * dy) + plane[2] * (oz + t * dz) > plane[3]) continue;
    nearest = t;
    triangle = k;
  }
  if (triangle < 0) return null;
  return {triangle, distance: nearest, point: [ox + nearest * dx, oy + nearest * dy, oz + nearest * dz]};
}

const plain = (triangle, corner) => 9 * triangle + 3 * corner;

/// The triangles of a mesh with shared vertices.
export const indexed = ({positions, triangles}) =>
  ({positions, triangles: triangles.length / 3, at: (triangle, corner) => 3 * triangles[3 * triangle + corner]});

/// A list of triangles as it is drawn: exploded around the centres of its cells.
export function exploded(list, middle) {
  const {positions, centers, explode, triangles} = list;
  if (!explode || !centers) return list;
  const shrink = 1 - 0.35 * explode;
  const moved = positions.map((x, i) => i < 9 * triangles ? centers[i] + explode * (centers[i] - middle[i % 3]) + shrink * (x - centers[i]) : 0);
  return {positions: moved, triangles};
}
