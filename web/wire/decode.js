/// Bulk numbers on the wire: {"dtype", "shape", "data": base64, little-endian}, or nested plain numbers.
const arrays = {
  float32: Float32Array, float64: Float64Array, int32: Int32Array, uint32: Uint32Array, uint8: Uint8Array,
};

export function decode_base64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

export function decode_array(value, fallback = Float32Array) {
  if (value === null || value === undefined) return null;
  if (Array.isArray(value)) return fallback.from(value.flat(2));
  const Type = arrays[value.dtype];
  if (!Type) throw new Error(`unknown dtype ${value.dtype}`);
  return new Type(decode_base64(value.data).buffer);
}

/// The same tree with every bulk array decoded; the buffers are collected, so that a worker can hand them over.
export function decode_tree(value, buffers) {
  if (value === null || typeof value !== 'object') return value;
  if (typeof value.dtype === 'string' && typeof value.data === 'string') {
    const array = decode_array(value);
    buffers.push(array.buffer);
    return array;
  }
  if (Array.isArray(value)) {
    if (value.length > 64 && typeof value[0] !== 'object') return value;
    return value.map(item => decode_tree(item, buffers));
  }
  for (const key of Object.keys(value)) value[key] = decode_tree(value[key], buffers);
  return value;
}

/// The query of positions that are wanted from an origin of their own: single precision would not tell them apart.
export const precision = origin => origin.some(Boolean) ? '?encoding=f64' : '';

/// Moves the positions and grids of a document so that they count from the origin, in single precision as they are drawn.
export function count_from(origin, document, buffers) {
  if (!origin.some(Boolean)) return;
  for (const grid of [document.grid, document.lattice?.grid]) if (grid) grid.origin = grid.origin.map((x, axis) => x - origin[axis]);
  if (!document.positions) return;
  document.positions = Float32Array.from(document.positions, (x, i) => x - origin[i % 3]);
  buffers.push(document.positions.buffer);
}

/// A body of a hello line or a topology document, as flat arrays.
export function decode_body(body) {
  return {
    ...body,
    tets: decode_array(body.tets, Int32Array),
    rest_positions: decode_array(body.rest_positions, Float64Array),
    masses: decode_array(body.masses, Float64Array),
    surface: decode_array(body.surface, Int32Array),
    cells: null,
  };
}

export function decode_frame(frame) {
  for (const body of frame.bodies) {
    if (!body.positions) continue;
    const positions = decode_array(body.positions);
    body.positions = positions instanceof Float32Array ? positions : Float32Array.from(positions);
  }
  return frame;
}

export const frame_buffers = frame => frame.bodies.flatMap(body => body.positions ? [body.positions.buffer] : []);
