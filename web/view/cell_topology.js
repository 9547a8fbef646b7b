/// A cell is five tets: 5c the central one, 5c+1 … 5c+4 its apexes, the apex vertex last. Its surface is twelve
/// triangles, the three outer ones of each apex tet; every two of them are one side of the cube.
export const faces_per_cell = 12;
export const tet_of_face = face => 5 * Math.floor(face / faces_per_cell) + 1 + Math.floor((face % faces_per_cell) / 3);

/// Outward faces of a tet with positive volume; the last three are outer ones of an apex tet.
export const tet_faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// Where the vertices of the twelve faces stand in a cell's twenty tet entries.
export const face_corners = Int32Array.from({length: 36}, (_, i) =>
  4 + 4 * Math.floor(i / 9) + tet_faces[1 + Math.floor((i % 9) / 3)][i % 3]);

// The corner patterns of core/tetrahedra, bit a of a corner its place along axis a.
const even = [0, 5, 3, 6, 5, 3, 6, 7, 0, 6, 3, 2, 0, 5, 6, 4, 0, 3, 5, 1];
const odd = [...Array(5).keys()].flatMap(t => [0, 2, 1, 3].map(k => even[4 * t + k] ^ 1));

/// Side of the cube (−x, +x, −y, +y, −z, +z) of each face, by parity: the bit that its corners share.
const sides = [even, odd].map(pattern => Array.from({length: faces_per_cell}, (_, face) => {
  const corners = [0, 1, 2].map(k => pattern[face_corners[3 * face + k]]);
  const axis = [0, 1, 2].find(a => corners.every(c => (c >> a & 1) === (corners[0] >> a & 1)));
  return 2 * axis + (corners[0] >> axis & 1);
}));

/// The cell across each of the 12·cells faces, −1 on the boundary. coords: the cells' places in the lattice, or null
/// where only the tets are known.
export function face_neighbours(tets, coords) {
  return coords ? by_coords(coords) : by_vertices(tets);
}

function by_coords(coords) {
  const cells = coords.length / 3;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < coords.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], coords[i]);
    high[i % 3] = Math.max(high[i % 3], coords[i]);
  }
  const [nx, ny, nz] = high.map((x, axis) => x - low[axis] + 3);  // a rim of empty cells
  const place = new Int32Array(nx * ny * nz).fill(-1);
  const at = cell => coords[3 * cell] - low[0] + 1 + nx * (coords[3 * cell + 1] - low[1] + 1 + ny * (coords[3 * cell + 2] - low[2] + 1));
  for (let cell = 0; cell < cells; ++cell) place[at(cell)] = cell;
  const steps = [-1, 1, -nx, nx, -nx * ny, nx * ny];
  const offsets = sides.map(table => Int32Array.from(table, side => steps[side]));
  const neighbour = new Int32Array(faces_per_cell * cells);
  for (let cell = 0; cell < cells; ++cell) {
    const offset = offsets[(coords[3 * cell] + coords[3 * cell + 1] + coords[3 * cell + 2]) & 1], here = at(cell);
    for (let face = 0; face < faces_per_cell; ++face) neighbour[faces_per_cell * cell + face] = place[here + offset[face]];
  }
  return neighbour;
}

/// Faces with the same three vertices; open addressing, for a Map of a million triples would take a second.
function by_vertices(tets) {
  const faces = faces_per_cell * Math.floor(tets.length / 20);
  const neighbour = new Int32Array(faces).fill(-1);
  let size = 1;
  while (size < 2 * faces) size *= 2;
  const slots = new Int32Array(size).fill(-1);
  const vertices = face => [0, 1, 2].map(k => tets[20 * Math.floor(face / faces_per_cell) + face_corners[3 * (face % faces_per_cell) + k]]).sort((a, b) => a - b);
  for (let face = 0; face < faces; ++face) {
    const key = vertices(face);
    let slot = (Math.imul(key[0], 73856093) ^ Math.imul(key[1], 19349663) ^ Math.imul(key[2], 83492791)) & (size - 1);
    for (; slots[slot] >= 0; slot = (slot + 1) & (size - 1)) {
      const other = slots[slot];
      if (!vertices(other).every((v, k) => v === key[k])) continue;
      neighbour[face] = Math.floor(other / faces_per_cell);
      neighbour[other] = Math.floor(face / faces_per_cell);
      break;
    }
    if (slots[slot] < 0) slots[slot] = face;
  }
  return neighbour;
}
