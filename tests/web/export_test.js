import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, eventually, no_complaints, tets} from './support/browser.js';

const suite = browser_tests();

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

test('a played clip leaves as GLB, MDD and PC2 with every frame', async () => {
  const page = await suite.open();
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
  no_complaints(page);
  await page.context().close();
});
