// Exports as readers that nobody here wrote take them: three.js' of USD, and MuJoCo itself.
import test, {after, before} from 'node:test';
import assert from 'node:assert/strict';
import load_mujoco from '@mujoco/mujoco';
import {Vector3} from '../../web/node_modules/three/build/three.module.js';
import {USDLoader} from '../../web/node_modules/three/examples/jsm/loaders/USDLoader.js';
import {USDAParser} from '../../web/node_modules/three/examples/jsm/loaders/usd/USDAParser.js';
import {start_server} from './support/server.js';

let server, model, text_of;
before(async () => {
  server = await start_server();
  const page = await (await fetch(server.url)).text();
  const headers = {Authorization: `Bearer ${/name="isochor-token" content="([^"]+)"/.exec(page)[1]}`, 'Content-Type': 'application/json'};
  const post = async (path, body) => (await fetch(`${server.url}api/v1${path}`, {method: 'POST', headers, body: JSON.stringify(body)})).json();
  const {id} = await post('/meshes?sample=torus');
  const job = await post('/models?wait_ms=10000', {mesh_id: id, params: {voxels: 64, cells: 12}});
  assert.equal(job.status, 'done');
  ({model} = job.result);
  text_of = async format => (await fetch(`${server.url}api/v1/models/${job.result.model_id}/exports/${format}`)).text();
});
after(() => server?.stop());

/// Six times the volume of the tets from the origin to each triangle, or of each tet.
const determinant = (a, b, c) => a.dot(b.clone().cross(c));

test('USD: the tets, and a surface that encloses their volume', async () => {
  const text = await text_of('usda');
  const {specsByPath} = new USDAParser().parseData(text);
  const field = name => specsByPath[`/model/tets.${name}`].fields.default;
  const points = field('points').flat(), tets = field('tetVertexIndices').flat();
  assert.deepEqual([points.length, tets.length], [3 * model.vertices, 4 * model.tets]);
  const point = i => new Vector3().fromArray(points, 3 * i);
  let volume = 0;
  for (let t = 0; t < tets.length; t += 4) {
    const [a, ...others] = tets.slice(t, t + 4).map(point);
    const tet = determinant(...others.map(other => other.sub(a))) / 6;
    assert.ok(tet > 0);
    volume += tet;
  }
  assert.ok(Math.abs(volume / model.volume - 1) < 1e-9);

  const surfaces = [];
  new USDLoader().parse(text).traverse(object => object.isMesh && surfaces.push(object.geometry.toNonIndexed().attributes.position.array));
  assert.equal(surfaces.length, 1);
  const [corners] = surfaces;
  let enclosed = 0;
  for (let k = 0; k < corners.length; k += 9) enclosed += determinant(...[0, 3, 6].map(at => new Vector3().fromArray(corners, k + at))) / 6;
  assert.ok(Math.abs(enclosed / model.volume - 1) < 1e-5);
});

test('MuJoCo: every tet is an element, the mass is that of water, and it falls and lands without a reset', async () => {
  const mujoco = await load_mujoco();
  const tar = Buffer.from(await text_of('msh4'), 'latin1');
  for (const [name, content] of files_of(tar)) mujoco.FS.writeFile(`/${name}`, content);
  const [xml] = files_of(tar).map(([name]) => name).filter(name => name.endsWith('.xml'));
  const floor = '<worldbody><geom type="plane" size="5 5 0.1" pos="0 0 -0.55"/>';
  mujoco.FS.writeFile(`/${xml}`, mujoco.FS.readFile(`/${xml}`, {encoding: 'utf8'}).replace('<worldbody>', floor));
  const read = mujoco.MjModel.from_xml_path(`/${xml}`), data = new mujoco.MjData(read);
  assert.deepEqual([read.nflex, read.nflexvert, read.nflexelem], [1, model.vertices, model.tets]);
  const mass = read.body_mass.reduce((sum, own) => sum + own, 0);
  assert.ok(Math.abs(mass / (1000 * model.volume) - 1) < 1e-9);
  for (let steps = 1; data.time < 0.15; ++steps) {
    mujoco.mj_step(read, data);
    assert.ok(data.time > (steps - 0.5) * read.opt.timestep, `reset at step ${steps}`);
  }
  assert.ok(data.qpos.every(q => Math.abs(q) < 0.2));
});

/// [name, content] of an archive's files: 512 bytes of head, the size in octal from byte 124 on.
function files_of(tar) {
  const files = [];
  for (let at = 0; tar[at] !== 0 && at < tar.length;) {
    const name = tar.toString('latin1', at, tar.indexOf(0, at)), size = parseInt(tar.toString('latin1', at + 124, at + 135), 8);
    files.push([name, tar.subarray(at + 512, at + 512 + size)]);
    at += 512 * (1 + Math.ceil(size / 512));
  }
  return files;
}
