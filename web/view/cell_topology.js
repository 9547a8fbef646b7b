/// A cell is five tets: 5c the central one, 5c+1 … 5c+4 its apexes. Its surface is twelve triangles, three on each
/// apex tet; two cells are neighbours when they share one.
export const faces_per_cell = 12;
export const tet_of_face = face => 5 * Math.floor(face / faces_per_cell) + 1 + Math.floor((face % faces_per_cell) / 3);

/// Outward faces of a tet with positive volume (b−a)·((c−a)×(d−a)) > 0.
export const tet_faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// outer: 3 vertices for each of 12·cells faces; neighbour: the cell across each face, −1 on the boundary.
export function cell_topology(tets) {
  const cells = Math.floor(tets.length / 20);
  const outer = new Int32Array(cells * faces_per_cell * 3);
  let at = 0;
  for (let cell = 0; cell < cells; ++cell) {
    const central = tets.subarray(20 * cell, 20 * cell + 4);
    for (let apex = 1; apex < 5; ++apex) at = append_apex_faces(tets, 20 * cell + 4 * apex, central, outer, at);
  }
  return {outer, neighbour: match_faces(outer)};
}

function append_apex_faces(tets, first, central, outer, at) {
  for (const [a, b, c] of tet_faces) {
    const [va, vb, vc] = [tets[first + a], tets[first + b], tets[first + c]];
    if (central.includes(va) && central.includes(vb) && central.includes(vc)) continue;
    outer[at++] = va;
    outer[at++] = vb;
    outer[at++] = vc;
  }
  return at;
}

/// Open addressing over the sorted vertex triples: a Map of a million triples would take a second.
function match_faces(outer) {
  const faces = outer.length / 3;
  const neighbour = new Int32Array(faces).fill(-1);
  let size = 1;
  while (size < 2 * faces) size *= 2;
  const slots = new Int32Array(size).fill(-1);
  const key = new Int32Array(3);
  const other = new Int32Array(3);
  for (let face = 0; face < faces; ++face) {
    sort_triple(outer, face, key);
    let slot = (Math.imul(key[0], 73856093) ^ Math.imul(key[1], 19349663) ^ Math.imul(key[2], 83492791)) & (size - 1);
    for (; slots[slot] >= 0; slot = (slot + 1) & (size - 1)) {
      const candidate = slots[slot];
      sort_triple(outer, candidate, other);
      if (other[0] !== key[0] || other[1] !== key[1] || other[2] !== key[2]) continue;
      neighbour[face] = Math.floor(candidate / faces_per_cell);
      neighbour[candidate] = Math.floor(face / faces_per_cell);
      break;
    }
    if (slots[slot] < 0) slots[slot] = face;
  }
  return neighbour;
}

function sort_triple(outer, face, out) {
  let a = outer[3 * face], b = outer[3 * face + 1], c = outer[3 * face + 2];
  if (a > b) [a, b] = [b, a];
  if (b > c) [b, c] = [c, b];
  if (a > b) [a, b] = [b, a];
  out[0] = a, out[1] = b, out[2] = c;
}
