const most_frames = 120;
const float_type = 5126, index_type = 5125;

/// glTF 2.0 binary: the first frame as a mesh, the others as morph targets with a weight track that shows one after
/// the other, linearly between.
export function make_glb({triangles, frames, rate, name}) {
  const stride = Math.ceil(frames.length / most_frames);
  const kept = frames.filter((_, k) => k % stride === 0);
  const writer = new BufferWriter();
  const vertices = kept[0].length / 3;
  const base = writer.add(kept[0], {componentType: float_type, count: vertices, type: 'VEC3', ...extent(kept[0])}, 34962);
  const indices = writer.add(Uint32Array.from(triangles), {componentType: index_type, count: triangles.length, type: 'SCALAR'}, 34963);
  const targets = kept.slice(1).map(frame => {
    const moved = frame.map((x, i) => x - kept[0][i]);
    return {POSITION: writer.add(moved, {componentType: float_type, count: vertices, type: 'VEC3', ...extent(moved)})};
  });
  const times = Float32Array.from(kept, (_, k) => k * stride / rate);
  const input = writer.add(times, {componentType: float_type, count: times.length, type: 'SCALAR', min: [0], max: [times.at(-1)]});
  const output = writer.add(weight_track(kept.length, targets.length), {componentType: float_type, count: kept.length * targets.length, type: 'SCALAR'});
  return writer.finish({
    asset: {version: '2.0', generator: 'Isochor'}, scene: 0, scenes: [{nodes: [0]}], nodes: [{mesh: 0, name}],
    meshes: [{name, weights: new Array(targets.length).fill(0), primitives: [{attributes: {POSITION: base}, indices, targets, material: 0}]}],
    materials: [{doubleSided: true, pbrMetallicRoughness: {baseColorFactor: [0.6, 0.52, 0.4, 1], metallicFactor: 0, roughnessFactor: 0.8}}],
    animations: [{name: 'simulation', samplers: [{input, output, interpolation: 'LINEAR'}], channels: [{sampler: 0, target: {node: 0, path: 'weights'}}]}],
  });
}

function weight_track(frames, targets) {
  const weights = new Float32Array(frames * targets);
  for (let k = 1; k < frames; ++k) weights[k * targets + k - 1] = 1;
  return weights;
}

function extent(positions) {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], x);
    max[i % 3] = Math.max(max[i % 3], x);
  });
  return {min, max};
}

class BufferWriter {
  constructor() {
    Object.assign(this, {parts: [], bytes: 0, views: [], accessors: []});
  }

  /// The index of the accessor. All items are multiples of four bytes, so every view is aligned.
  add(array, accessor, target) {
    this.views.push({buffer: 0, byteOffset: this.bytes, byteLength: array.byteLength, ...target ? {target} : {}});
    this.parts.push(array);
    this.bytes += array.byteLength;
    return this.accessors.push({bufferView: this.views.length - 1, ...accessor}) - 1;
  }

  finish(document) {
    const json = new TextEncoder().encode(JSON.stringify({...document, buffers: [{byteLength: this.bytes}], bufferViews: this.views, accessors: this.accessors}));
    const padding = (4 - json.length % 4) % 4;
    const head = (...words) => Uint32Array.from(words);
    const total = 12 + 8 + json.length + padding + 8 + this.bytes;
    return new Blob([head(0x46546c67, 2, total), head(json.length + padding, 0x4e4f534a), json, ' '.repeat(padding),
      head(this.bytes, 0x004e4942), ...this.parts], {type: 'model/gltf-binary'});
  }
}
