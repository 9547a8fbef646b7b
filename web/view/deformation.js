/// Weights that are no numbers would reach the graphics driver as positions; such a vertex follows its tet's centre.
export function finite_weights(weights) {
  for (let v = 0; v < weights.length; v += 4)
    if (!Number.isFinite(weights[v] + weights[v + 1] + weights[v + 2] + weights[v + 3])) weights.fill(0.25, v, v + 4);
  return weights;
}

/// out = Σ weights · tet vertices, for each embedded vertex [Milliron 2002].
export function apply_embedding({tet, weights}, tets, positions, out) {
  for (let v = 0; v < tet.length; ++v) {
    const t = 4 * tet[v], w = 4 * v;
    const a = 3 * tets[t], b = 3 * tets[t + 1], c = 3 * tets[t + 2], d = 3 * tets[t + 3];
    const wa = weights[w], wb = weights[w + 1], wc = weights[w + 2], wd = weights[w + 3];
    for (let axis = 0; axis < 3; ++axis)
      out[3 * v + axis] = wa * positions[a + axis] + wb * positions[b + axis] + wc * positions[c + axis] + wd * positions[d + axis];
  }
}

/// Six times the signed volume of tet t.
export function tet_volume6(p, tets, t) {
  const a = 3 * tets[4 * t], b = 3 * tets[4 * t + 1], c = 3 * tets[4 * t + 2], d = 3 * tets[4 * t + 3];
  const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
  const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
  const wx = p[d] - p[a], wy = p[d + 1] - p[a + 1], wz = p[d + 2] - p[a + 2];
  return ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
}

export function cell_volumes(positions, tets) {
  const volumes = new Float64Array(Math.floor(tets.length / 20));
  for (let t = 0; t < 5 * volumes.length; ++t) volumes[Math.floor(t / 5)] += tet_volume6(positions, tets, t) / 6;
  return volumes;
}

export function inverted_tets(positions, tets) {
  const bad = [];
  for (let t = 0; t < tets.length / 4; ++t) if (tet_volume6(positions, tets, t) <= 0) bad.push(t);
  return bad;
}
