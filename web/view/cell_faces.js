import {face_corners, faces_per_cell, tet_of_face} from './cell_topology.js';

const most_exploded = 40000;  // cells; deeper ones are hidden by those before them

/// Whether a cell is hidden, seen, or seen with a hidden neighbour across some side.
export const hidden = 0, seen = 1, at_edge = 2;

/// Writes the faces of the visible cells that nothing visible covers into a TriangleList; with `centers` every face of
/// the outer layers of cells, and the cell's centre beside it, so that the list can be exploded.
/// cells: {positions, tets, neighbour}; visible: hidden, seen or at_edge (or perhaps so) a cell, or null for all;
/// values: a number a tet, or null.
export function draw_cells(list, cells, {visible = null, values = null, centers = null} = {}) {
  cells.boundary ??= boundary_cells(cells.neighbour);
  const exposed = exposed_faces(cells, visible);
  const faces = centers ? faces_of_layers(cells.neighbour, visible, exposed) : exposed;
  list.reserve(faces.length, Boolean(centers));
  list.faces = faces;
  move_cells(list, cells, values, centers);
}

/// The same faces at new positions (a simulation's frame).
export function move_cells(list, {positions, tets}, values = null, centers = null) {
  const {faces, positions: out} = list;
  for (let k = 0, to = 0; k < faces.length; ++k) {
    const face = faces[k];
    const cell = Math.floor(face / faces_per_cell), corner = 3 * (face - faces_per_cell * cell);
    for (let c = 0; c < 3; ++c) {
      const from = 3 * tets[20 * cell + face_corners[corner + c]];
      out[to++] = positions[from];
      out[to++] = positions[from + 1];
      out[to++] = positions[from + 2];
    }
  }
  if (values) write_values(list, faces, values);
  if (centers) write_centers(list, faces, centers);
  list.upload(faces.length);
}

/// 1 where a cell has a side on the model's boundary.
export function boundary_cells(neighbour) {
  const boundary = new Uint8Array(neighbour.length / faces_per_cell);
  for (let face = 0; face < neighbour.length; ++face) if (neighbour[face] < 0) boundary[Math.floor(face / faces_per_cell)] = 1;
  return boundary;
}

function exposed_faces({neighbour, boundary}, visible) {
  let shown = new Int32Array(1024), count = 0;
  for (let cell = 0; cell < boundary.length; ++cell) {
    if (visible && visible[cell] === hidden || !boundary[cell] && !(visible && visible[cell] === at_edge)) continue;
    const first = faces_per_cell * cell;
    if (count + faces_per_cell > shown.length) shown = grown(shown);
    for (let face = first; face < first + faces_per_cell; ++face) {
      const other = neighbour[face];
      if (other < 0 || (visible && visible[other] === hidden)) shown[count++] = face;
    }
  }
  return shown.subarray(0, count);
}

/// All faces of the cells with an exposed one, and of the layers behind them.
function faces_of_layers(neighbour, visible, exposed) {
  const reached = new Uint8Array(neighbour.length / faces_per_cell);
  let layer = [];
  const reach = cell => {
    if (reached[cell] || visible && visible[cell] === hidden) return;
    reached[cell] = 1;
    layer.push(cell);
  };
  for (const face of exposed) reach(Math.floor(face / faces_per_cell));
  const cells = [];
  while (layer.length && cells.length < most_exploded) {
    const front = layer;
    layer = [];
    for (const cell of front) {
      cells.push(cell);
      for (let face = faces_per_cell * cell; face < faces_per_cell * (cell + 1); ++face) if (neighbour[face] >= 0) reach(neighbour[face]);
    }
  }
  return Int32Array.from({length: faces_per_cell * cells.length}, (_, k) => faces_per_cell * cells[Math.floor(k / faces_per_cell)] + k % faces_per_cell);
}

function grown(array) {
  const larger = new Int32Array(2 * array.length);
  larger.set(array);
  return larger;
}

function write_values({values: out}, faces, values) {
  for (let k = 0; k < faces.length; ++k) out[3 * k] = out[3 * k + 1] = out[3 * k + 2] = values[tet_of_face(faces[k])];
}

function write_centers({centers: out}, faces, {cells}) {
  for (let k = 0, to = 0; k < faces.length; ++k) {
    const at = 3 * Math.floor(faces[k] / faces_per_cell);
    for (let corner = 0; corner < 3; ++corner) for (let axis = 0; axis < 3; ++axis) out[to++] = cells[at + axis];
  }
}

/// Centre of each cell (mean of its central tet's vertices) and of them all.
export function cell_centers({positions, tets}) {
  const cells = new Float32Array(3 * Math.floor(tets.length / 20));
  const middle = [0, 0, 0];
  for (let cell = 0; cell < cells.length / 3; ++cell)
    for (let axis = 0; axis < 3; ++axis) {
      let sum = 0;
      for (let corner = 0; corner < 4; ++corner) sum += positions[3 * tets[20 * cell + corner] + axis];
      cells[3 * cell + axis] = sum / 4;
      middle[axis] += sum / 4;
    }
  return {cells, middle: middle.map(sum => sum / Math.max(1, cells.length / 3))};
}
