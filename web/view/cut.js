/// The cross-section of tets with the plane n·x = w, coloured by tet, as quads of two triangles each. A triangle
/// becomes the quad p0, p1, middle of p1p2, p2, so that all its edges are outer ones.
export function draw_cut(list, {positions, tets}, plane, {visible = null, values = null} = {}) {
  const quads = [];
  const side = vertex_sides(positions, plane);
  for (let tet = 0; tet < tets.length / 4; ++tet) {
    if (visible && !visible[Math.floor(tet / 5)]) continue;
    const polygon = tet_polygon(positions, tets, tet, side);
    if (polygon) quads.push({polygon, tet, value: values ? values[tet] : 0});
  }
  list.reserve(2 * quads.length);
  quads.forEach(({polygon: [a, b, c, d], value}, k) => {
    list.positions.set([...a, ...b, ...c, ...c, ...d, ...a], 18 * k);
    list.values.fill(value, 6 * k, 6 * k + 6);
  });
  list.upload(2 * quads.length);
  list.tets = Int32Array.from(quads, ({tet}) => tet);
}

function vertex_sides(positions, [nx, ny, nz, w]) {
  const side = new Float32Array(positions.length / 3);
  for (let i = 0; i < side.length; ++i)
    side[i] = nx * positions[3 * i] + ny * positions[3 * i + 1] + nz * positions[3 * i + 2] - w;
  return side;
}

function tet_polygon(positions, tets, tet, side) {
  const inside = [], outside = [];
  for (let k = 0; k < 4; ++k) {
    const vertex = tets[4 * tet + k];
    (side[vertex] <= 0 ? inside : outside).push(vertex);
  }
  if (!inside.length || !outside.length) return null;
  const cross = (a, b) => {
    const s = side[a] / (side[a] - side[b]);
    return [0, 1, 2].map(axis => positions[3 * a + axis] + s * (positions[3 * b + axis] - positions[3 * a + axis]));
  };
  if (inside.length === 2) {
    const [[a, b], [c, d]] = [inside, outside];
    return [cross(a, c), cross(a, d), cross(b, d), cross(b, c)];
  }
  const [single] = inside.length === 1 ? inside : outside;
  const [p0, p1, p2] = (inside.length === 1 ? outside : inside).map(other => cross(single, other));
  return [p0, p1, p1.map((x, axis) => (x + p2[axis]) / 2), p2];
}
