import {apply_embedding} from '../view/deformation.js';
import {make_glb} from './glb.js';
import {make_vtu_series} from './vtu.js';

/// The first deformable body as a clip: the vertices that its user knows (the embedded mesh, or the boundary of the
/// tets), its triangles, and the vertices at each buffered frame.
function clip_of({bodies, buffer, info}) {
  const {body, frames, rate} = tets_of({bodies, buffer, info});
  if (!body.embedded) return {triangles: body.surface, frames, rate, name: body.name};
  const {tet, triangles} = body.embedded;
  const skins = frames.map(positions => {
    const out = new Float32Array(3 * tet.length);
    apply_embedding(body.embedded, body.tets, positions, out);
    return out;
  });
  return {triangles, frames: skins, rate, name: body.name};
}

/// The same body's tets at each buffered frame.
function tets_of({bodies, buffer, info}) {
  const body = bodies.find(({type}) => type === 'deformable');
  const frames = buffer.frames.map(frame => frame.bodies.find(({id}) => id === body.id).positions);
  return {body, frames, rate: info?.frame_rate ?? 60};
}

/// NewTek MDD: frame and point counts, times, then positions; all big-endian.
export function make_mdd({frames, rate}) {
  const points = frames[0].length / 3;
  const view = new DataView(new ArrayBuffer(8 + 4 * frames.length + 12 * points * frames.length));
  view.setInt32(0, frames.length);
  view.setInt32(4, points);
  frames.forEach((_, k) => view.setFloat32(8 + 4 * k, k / rate));
  let at = 8 + 4 * frames.length;
  for (const frame of frames) for (const x of frame) view.setFloat32(at, x), at += 4;
  return new Blob([view.buffer], {type: 'application/octet-stream'});
}

/// PC2: "POINTCACHE2\0", version 1, points, first sample, samples a frame, frames; little-endian.
export function make_pc2({frames}) {
  const points = frames[0].length / 3;
  const view = new DataView(new ArrayBuffer(32 + 12 * points * frames.length));
  [...'POINTCACHE2\0'].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
  view.setInt32(12, 1, true);
  view.setInt32(16, points, true);
  view.setFloat32(20, 0, true);
  view.setFloat32(24, 1, true);
  view.setInt32(28, frames.length, true);
  let at = 32;
  for (const frame of frames) for (const x of frame) view.setFloat32(at, x, true), at += 4;
  return new Blob([view.buffer], {type: 'application/octet-stream'});
}

export const animation_formats = [
  {title: 'Animated GLB', extension: '.glb', note: 'Morph targets of the mesh, for three.js, Blender and engines; up to 120 frames are kept.', make: sim => make_glb(clip_of(sim))},
  {title: 'MDD point cache', extension: '.mdd', note: 'Big-endian vertex positions for Blender, Modo and LightWave.', make: sim => make_mdd(clip_of(sim))},
  {title: 'PC2 point cache', extension: '.pc2', note: 'Vertex positions for 3ds Max, Maya and Blender.', make: sim => make_pc2(clip_of(sim))},
  {title: 'VTU series', extension: '.tar', note: 'The tets of each frame with displacement and volume error, and a .pvd with the times, for ParaView and PyVista.',
    make: (sim, stem) => make_vtu_series({...tets_of(sim), stem})},
];
