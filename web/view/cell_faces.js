import {faces_per_cell, tet_of_face} from './cell_topology.js';

/// Writes the faces of the visible cells that nothing visible covers into a TriangleList; with `explode` > 0 every
/// face of a visible cell, the cell moved away from the centre of all and drawn a little smaller.
/// cells: {positions, outer, neighbour}; visible: a byte a cell, or null for all; values: a number a tet, or null.
export function draw_cells(list, cells, {visible = null, values = null, explode = 0, centers = null} = {}) {
  const {outer, neighbour} = cells;
  const faces = outer.length / 3;
  const shown = new Int32Array(faces);
  let count = 0;
  for (let face = 0; face < faces; ++face) {
    if (visible && !visible[Math.floor(face / faces_per_cell)]) continue;
    const other = neighbour[face];
    if (explode > 0 || other < 0 || (visible && !visible[other])) shown[count++] = face;
  }
  list.reserve(count);
  for (let k = 0; k < count; ++k) write_face(list, k, cells, shown[k], values);
  if (explode > 0) explode_faces(list, shown, count, explode, centers);
  list.upload(count);
  list.faces = shown.subarray(0, count);
}

/// The same faces at new positions (a simulation's frame).
export function move_cells(list, cells, values = null) {
  list.faces.forEach((face, k) => write_face(list, k, cells, face, values));
  list.upload(list.faces.length);
}

function write_face(list, k, {positions, outer}, face, values) {
  const out = list.positions;
  for (let corner = 0; corner < 3; ++corner) {
    const from = 3 * outer[3 * face + corner], to = 9 * k + 3 * corner;
    out[to] = positions[from];
    out[to + 1] = positions[from + 1];
    out[to + 2] = positions[from + 2];
  }
  if (!values) return;
  list.values.fill(values[tet_of_face(face)], 3 * k, 3 * k + 3);
}

function explode_faces(list, shown, count, explode, {cells, middle}) {
  const shrink = 1 - 0.35 * explode;
  for (let k = 0; k < count; ++k) {
    const cell = 3 * Math.floor(shown[k] / faces_per_cell);
    for (let at = 9 * k; at < 9 * k + 9; ++at) {
      const axis = at % 3, center = cells[cell + axis];
      list.positions[at] = center + explode * (center - middle[axis]) + shrink * (list.positions[at] - center);
    }
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
