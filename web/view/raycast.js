/// Nearest hit of a ray {origin, direction} with a TriangleList in its own coordinates: {triangle, distance, point},
/// or null. plane [nx, ny, nz, w]: what lies beyond it is cut away.
export function raycast(list, ray, plane = null) {
  const p = list.positions;
  const {x: ox, y: oy, z: oz} = ray.origin, {x: dx, y: dy, z: dz} = ray.direction;
  let nearest = Infinity, triangle = -1;
  for (let k = 0; k < list.triangles; ++k) {
    const i = 9 * k;
    // Möller & Trumbore 1997
    const ex = p[i + 3] - p[i], ey = p[i + 4] - p[i + 1], ez = p[i + 5] - p[i + 2];
    const fx = p[i + 6] - p[i], fy = p[i + 7] - p[i + 1], fz = p[i + 8] - p[i + 2];
    const hx = dy * fz - dz * fy, hy = dz * fx - dx * fz, hz = dx * fy - dy * fx;
    const det = ex * hx + ey * hy + ez * hz;
    if (Math.abs(det) < 1e-20) continue;
    const sx = ox - p[i], sy = oy - p[i + 1], sz = oz - p[i + 2];
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
