import test from 'node:test';
import assert from 'node:assert/strict';
import {execFile} from 'node:child_process';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {promisify} from 'node:util';
import {browser_tests, eventually, hold_at_preview, no_complaints, tets} from './support/browser.js';

const suite = browser_tests();

/// What VTK's readers of glTF and VTU and a reader of point caches in Python find in the files.
async function read_by_others(files) {
  const folder = await mkdtemp(join(tmpdir(), 'isochor-'));
  try {
    for (const [extension, bytes] of Object.entries(files)) await writeFile(join(folder, `clip.${extension}`), bytes);
    const {stdout} = await promisify(execFile)('/usr/bin/python3', [fileURLToPath(new URL('support/read_animations.py', import.meta.url)), folder]);
    return JSON.parse(stdout);
  } finally {
    await rm(folder, {recursive: true});
  }
}

/// The consumers' buttons, and who reads what they save (see tests/export/read_back.py); of an archive, one file.
const readers = [
  [/Save for Gmsh/, 'gmsh'], [/Save for MuJoCo/, 'gmsh', 'tree.msh'], [/Save for ParaView/, 'vtk'], [/Save for older VTK/, 'vtk'],
  [/Save for TetGen/, 'tetgen', 'tree.node'], [/Save for fTetWild/, 'meshio'], [/Save for any viewer/, 'meshio'],
  [/Save for MeshLab/, 'meshio'], [/Save for printing/, 'vtk']];

async function save(page, name) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name}).click()]);
  return {name: file.suggestedFilename(), bytes: await readFile(await file.path())};
}

test('the dialog names the consumers and gives each its file', async () => {
  const page = await suite.open();
  const expected = await tets(page);
  await page.keyboard.press('e');
  const dialog = page.getByRole('dialog', {name: 'Export'});
  await dialog.waitFor();
  for (const consumer of ['SOFA', 'MuJoCo flexcomp', 'ParaView', 'TetGen', 'fTetWild', 'USD', 'three.js'])
    assert.ok((await dialog.getByText(consumer).count()) > 0, consumer);
  const {name, bytes} = await save(page, /Save for Gmsh/);
  assert.match(name, /\.msh$/);
  const text = bytes.toString();
  assert.match(text, /^\$MeshFormat\n2\.2 0 8/);
  assert.equal(Number(/\$Elements\n(\d+)/.exec(text)[1]), expected);
  no_complaints(page);
  await page.context().close();
});

test('what is saved while a preview is shown waits for the whole model', async () => {
  const page = await suite.open();
  const release = await hold_at_preview(page, 'Cells', 22);
  await page.keyboard.press('e');
  const saved = page.waitForEvent('download');
  await page.getByRole('button', {name: /Save for engines that skin/}).click();
  await page.evaluate(() => new Promise(requestAnimationFrame));
  release();
  const {tet, count} = JSON.parse(await readFile(await (await saved).path()));
  assert.ok(count > 0 && tet.length === count, `${count} vertices`);
  no_complaints(page);
  await page.context().close();
});

test('what the buttons save is read by others as the model that is shown', async () => {
  const page = await suite.open();
  const expected = await tets(page);
  await page.keyboard.press('e');
  const folder = await mkdtemp(join(tmpdir(), 'isochor-')), run = promisify(execFile);
  try {
    const volumes = [];
    for (const [button, reader, part] of readers) {
      const {name, bytes} = await save(page, button);
      await writeFile(join(folder, name), bytes);
      if (part) await run('tar', ['xf', name], {cwd: folder});
      const script = fileURLToPath(new URL('../export/read_back.py', import.meta.url));
      const {stdout} = await run('/usr/bin/python3', [script, reader, join(folder, part ?? name)]);
      const seen = JSON.parse(stdout);
      if (seen.tets) assert.equal(seen.tets, expected, name);
      volumes.push(seen.volume ?? seen.enclosed);
    }
    assert.ok(volumes.every(volume => Math.abs(volume / volumes[0] - 1) < 1e-5), `volumes ${volumes}`);
    JSON.parse((await save(page, /Save for engines that skin/)).bytes);
    assert.equal(JSON.parse((await save(page, /Save for three.js/)).bytes).tetIds.length, 4 * expected);
    assert.match((await save(page, /Save for USD/)).bytes.toString(), /^#usda 1.0/);
  } finally {
    await rm(folder, {recursive: true});
  }
  no_complaints(page);
  await page.context().close();
});

test('a played clip leaves as GLB, MDD, PC2 and VTU series with every frame, as others read them', async () => {
  const page = await suite.open();
  const expected = await tets(page);
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await eventually(() => page.locator('.transport .time').textContent(), text => /step 1 /.test(text), 'one step');
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await eventually(() => page.locator('.transport .time').textContent(), text => /step 2 /.test(text), 'two steps');
  await page.keyboard.press('e');
  const mdd = (await save(page, 'Save MDD point cache')).bytes;
  const points = mdd.readInt32BE(4);
  assert.equal(mdd.readInt32BE(0), 3);
  assert.equal(mdd.length, 8 + 4 * 3 + 12 * 3 * points);
  const pc2 = (await save(page, 'Save PC2 point cache')).bytes;
  assert.equal(pc2.subarray(0, 11).toString(), 'POINTCACHE2');
  assert.deepEqual([pc2.readInt32LE(16), pc2.readInt32LE(28)], [points, 3]);
  const glb = (await save(page, 'Save Animated GLB')).bytes;
  assert.equal(glb.readUInt32LE(8), glb.length);
  const document = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString());
  assert.equal(document.meshes[0].primitives[0].targets.length, 2);
  assert.equal(document.accessors[document.meshes[0].primitives[0].attributes.POSITION].count, points);
  const tar = (await save(page, 'Save VTU series')).bytes;
  const seen = await read_by_others({glb, mdd, pc2, tar});
  assert.equal(seen.glb_points, points);
  assert.deepEqual(seen.times.map(t => t.toFixed(4)), ['0.0000', '0.0167', '0.0333']);
  assert.deepEqual(seen.tets, Array(3).fill(expected));
  assert.ok(seen.volumes.every(volume => Math.abs(volume / seen.volumes[0] - 1) < 1e-5), `volumes ${seen.volumes}`);
  assert.ok(seen.largest_difference < 1e-6, `MDD and PC2 differ by ${seen.largest_difference}`);
  assert.ok(seen.glb_difference < 1e-4, `GLB and PC2 differ by ${seen.glb_difference}`);
  no_complaints(page);
  await page.context().close();
});
