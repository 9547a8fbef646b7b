import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, drop, eventually, fact, no_complaints, status, tets, tets_ready} from './support/browser.js';
import {look_at_rest} from './support/pixels.js';

const suite = browser_tests();

const cube = `${[...Array(8).keys()].map(i => `v ${i & 1} ${i >> 1 & 1} ${i >> 2 & 1}`).join('\n')}
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n`;
const open_cube = cube.replace('f 2 4 8 6\n', '');

const choose = (page, name, text) => page.locator('input[type=file]').setInputFiles({name, mimeType: 'text/plain', buffer: Buffer.from(text)});

test('a dropped mesh becomes a model, and its report counts what is wrong', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  await drop(page, 'open cube.obj', open_cube);
  await eventually(() => fact(page, 'Vertices'), n => n === 8, 'the report of the cube');
  await eventually(() => tets(page), n => n !== tree, 'the model of the cube');
  await page.getByText('ready to play').waitFor();
  assert.equal(await page.getByRole('button', {name: 'Tets', exact: true}).getAttribute('aria-pressed'), 'true', 'in place of the run');
  await page.getByRole('button', {name: /open edges: fly to the next/}).click();
  await status(page).filter({hasText: /open edges: 1 of/}).waitFor();
  await choose(page, 'same cube.obj', open_cube);  // which the server knows by its first name
  await page.locator('header').getByText('same cube').waitFor();
  await tets_ready(page);
  await page.getByRole('button', {name: 'Undo'}).click();
  await status(page).filter({hasText: 'Undone: open same cube.obj'}).waitFor();
  no_complaints(page);
  await page.context().close();
});

test('of two meshes dropped at once the last one stays, and one step back is what was before both', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  let dropped_both;
  const both = new Promise(resolve => dropped_both = resolve);
  await page.route('**/meshes?name=slow.obj', async route => {
    await both;
    await route.continue();
  });
  const answered = page.waitForResponse('**/meshes?name=slow.obj');
  await drop(page, 'slow.obj', open_cube.replace('v 0 0 0', 'v 0 0 -2'));
  await drop(page, 'cube.obj', cube);
  dropped_both();
  await (await answered).finished();
  await eventually(() => tets(page), n => n !== tree, 'the model of the cube');
  assert.equal(await page.locator('.mesh-name').textContent(), 'cube');
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => tets(page), n => n === tree, 'the tree again');
  no_complaints(page);
  await page.context().close();
});

test('a mesh that takes long to be read says so and can be cancelled, and the last model stays', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  await page.route('**/meshes?name=slow.obj', () => {});  // never answered
  await choose(page, 'slow.obj', cube);
  const card = page.locator('.progress-card', {hasText: 'Opening slow.obj'});
  await card.getByRole('button', {name: 'Cancel'}).click();
  await status(page).filter({hasText: 'Cancelled'}).waitFor();
  await card.waitFor({state: 'hidden'});
  assert.equal(await tets(page), tree);
  assert.equal(await page.locator('.mesh-name').textContent(), 'tree');
  assert.equal(await page.locator('.problem-card').count(), 0);
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  no_complaints(page);
  await page.context().close();
});

test('until another mesh is known, the last one stands with its own settings', async () => {
  const page = await suite.open();
  const settings = () => page.evaluate(() => [document.querySelector('.mesh-name').textContent,
    document.querySelector('[data-path="params.p_in_voxels"] input[type=number]').value, document.querySelector('[aria-label="Show the surface as"]').value]);
  const of_tree = await settings();
  let go_on;
  const held = new Promise(resolve => go_on = resolve);
  await page.route('**/meshes?name=cube.obj', async route => (await held, route.continue()));
  await choose(page, 'cube.obj', cube);
  await page.locator('.progress-card', {hasText: 'Opening cube.obj'}).waitFor();
  assert.deepEqual(await settings(), of_tree);
  go_on();
  await page.locator('header').getByText('cube').waitFor();
  const [name, p_in, look] = await settings();
  assert.ok(name === 'cube' && p_in !== of_tree[1] && look !== of_tree[2], [name, p_in, look].join());
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(settings, now => String(now) === String(of_tree), 'the tree and its settings');
  no_complaints(page);
  await page.context().close();
});

/// A ball of triangles about (at, at, at), in steps that doubles have at any such distance.
function ball(at, rows = 24) {
  const round = x => at + Math.round(256 * x) / 256, corner = (i, j) => 1 + i * rows + j % rows;
  const angles = [...Array(rows + 1).keys()].map(i => i * Math.PI / rows);
  const vertices = angles.flatMap(polar => [...Array(rows).keys()].map(j => j * 2 * Math.PI / rows).map(turn =>
    `v ${round(Math.sin(polar) * Math.cos(turn))} ${round(Math.cos(polar))} ${round(Math.sin(polar) * Math.sin(turn))}`));
  const faces = angles.slice(1).flatMap((_, i) => [...Array(rows).keys()].map(j =>
    `f ${corner(i, j)} ${corner(i, j + 1)} ${corner(i + 1, j + 1)} ${corner(i + 1, j)}`));
  return [...vertices, ...faces].join('\n');
}

test('a mesh far from its origin looks as it does near it: its surface, voxels and tets, and P along a ray', async () => {
  const seen = [];
  for (const at of [0, 2 ** 22]) {
    const page = await suite.open();
    const tree = await tets(page);
    await choose(page, `ball ${at}.obj`, ball(at));
    await eventually(() => tets(page), n => n !== tree, 'the model of the ball');
    const pictures = [await look_at_rest(page)];
    const voxels = page.waitForResponse('**/voxels*');
    for (const key of '132') await page.keyboard.press(key);
    await (await voxels).finished();
    pictures.push(await eventually(() => look_at_rest(page), s => s.tets > 1000, 'the voxels'));
    await page.keyboard.press('p');
    await page.getByRole('img', {name: /^P along the ray/}).waitFor();
    seen.push(pictures.map(({tets: green, sand}) => [green, sand]).flat());
    no_complaints(page);
    await page.context().close();
  }
  seen[0].forEach((pixels, k) => assert.ok(Math.abs(seen[1][k] - pixels) < 0.02 * pixels + 50, JSON.stringify(seen)));
});

test('units, up axis and fit place the body in the world', async () => {
  const page = await suite.open();
  await choose(page, 'cube.obj', cube);
  await eventually(() => fact(page, 'Vertices'), n => n === 8, 'the cube');
  await page.getByLabel('Fit to one metre', {exact: true}).uncheck();
  await page.getByLabel('File unit', {exact: true}).selectOption('0.01');
  await page.getByLabel('Up axis of the file', {exact: true}).selectOption('z');
  await page.getByRole('button', {name: 'Export', exact: true}).click();
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name: 'Save the scene'}).click()]);
  const scene = JSON.parse(await readFile(await file.path(), 'utf8'));
  assert.equal(scene.bodies[0].scale, 0.01);
  assert.deepEqual(scene.bodies[0].orientation.map(x => Number(x.toFixed(4))), [-0.7071, 0, 0, 0.7071]);
  await page.context().close();
});

test('meshes of huge and of tiny units are fitted and simulated', async () => {
  const page = await suite.open();
  for (const [name, unit] of [['huge.obj', 2e8], ['tiny.obj', 2e-8]]) {
    await choose(page, name, cube.replace(/(?<=^v.*)-?[\d.]+/gm, x => x * unit));
    await eventually(() => fact(page, 'Vertices'), n => n === 8, 'the cube');
    await page.locator('.transport .time').filter({hasText: 'ready to play'}).waitFor();
    await page.getByRole('button', {name: 'Step (.)'}).click();
    await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  }
  no_complaints(page);
  await page.context().close();
});

const scene_of_meshes = JSON.stringify({name: 'landing', duration: null, frame_rate: 60, gravity: [0, -9.81, 0], bodies: [
  {name: 'cube', type: 'deformable', mesh: 'meshes/dice.obj', meshing: {voxels: 32, cells: 6}, position: [0, 2, 0], density: 300,
    edge_stiffness: 3000, diagonal_stiffness: 1000},
  {name: 'rock', type: 'rigid', shape: {mesh: {file: 'meshes/rock.obj', meshing: {voxels: 32, cells: 6}}}, static: true, position: [0, 0, 0]}]});

test('a scene asks for the meshes that are not open, and keeps what was there until it has them', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  await choose(page, 'landing.json', scene_of_meshes);
  const card = page.locator('.problem-card');
  await card.filter({hasText: 'needs dice.obj and rock.obj, which are not open'}).waitFor();
  assert.equal(await page.getByRole('button', {name: 'Tets', exact: true}).getAttribute('aria-pressed'), 'true');
  assert.equal(await tets(page), tree);
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), card.getByRole('button', {name: 'Open dice.obj and rock.obj'}).click()]);
  await chooser.setFiles(['dice.obj', 'rock.obj'].map(name => ({name, mimeType: 'text/plain', buffer: Buffer.from(cube)})));
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  assert.equal(await card.count(), 0);
  await page.getByRole('button', {name: 'Undo'}).click();
  await page.getByText('ready to play').waitFor();
  assert.equal(await page.getByRole('button', {name: 'Tets', exact: true}).getAttribute('aria-pressed'), 'true');
  no_complaints(page);
  await page.context().close();
});

test('a damaged file says what, where and what next, and the last model stays', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  await choose(page, 'broken.obj', 'v 0 0 0\nf 1 2 9\n');
  const card = page.locator('.problem-card');
  await card.waitFor();
  assert.match(await card.textContent(), /^broken\.obj: line 2/);
  assert.equal(await tets(page), tree);
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), card.getByRole('button', {name: 'Open another file'}).click()]);
  await chooser.setFiles({name: 'cube.obj', mimeType: 'text/plain', buffer: Buffer.from(cube)});
  await eventually(() => fact(page, 'Vertices'), n => n === 8, 'the cube');
  await eventually(() => tets(page), n => n !== tree, 'the model of the cube');
  assert.equal(await card.count(), 0);
  await page.context().close();
});

test('a mesh that leaves nothing is answered with a fix of one click', async () => {
  const page = await suite.open();
  await choose(page, 'triangle.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n');
  const card = page.locator('.problem-card');
  await card.filter({hasText: 'no lattice cell is filled enough'}).waitFor();
  assert.match(await page.getByRole('region', {name: 'Lattice'}).locator('summary').textContent(), /failed$/);
  await page.locator('.inspector').getByText('No model yet.').waitFor();
  assert.equal(await page.locator('dt', {hasText: /^P_(in|subs)$/}).count(), 0, 'thresholds of the mesh before');
  await page.locator('.transport .time').filter({hasText: 'no model yet'}).waitFor();
  await card.locator('button.primary').first().click();
  await tets_ready(page);
  await card.waitFor({state: 'detached'});
  assert.ok(await tets(page) > 0);
  await page.context().close();
});

test('what was picked of one mesh does not stand beside the next, even when that one leaves nothing', async () => {
  const page = await suite.open();
  const ray = page.getByRole('img', {name: /^P along the ray/});
  await page.keyboard.press('p');
  await ray.waitFor();
  await choose(page, 'triangle.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n');
  await page.locator('.problem-card').filter({hasText: 'no lattice cell is filled enough'}).waitFor();
  await page.getByText('Click a cell or a voxel in the view').waitFor();
  assert.equal(await ray.count(), 0);
  no_complaints(page);
  await page.context().close();
});

test('walls thinner than the cells are answered with the cells and voxels that hold them, by one click', async () => {
  const page = await suite.open();
  const needle = cube.replace(/^v (\S+) (\S+) (\S+)$/gm, (_, x, y, z) => `v ${10 * x} ${0.3 * y} ${0.2 * z}`);
  await choose(page, 'needle.obj', needle);
  const card = page.locator('.problem-card');
  await card.filter({hasText: /try \d+ cells and \d+ voxels/}).waitFor();
  const [, cells, voxels] = /try (\d+) cells and (\d+) voxels/.exec(await card.textContent());
  await card.getByRole('button', {name: `Set Cells to ${cells} and Voxels to ${voxels}`}).click();
  await card.waitFor({state: 'detached'});
  await eventually(() => tets(page), n => n > 0, 'the model of the needle');
  assert.equal(await page.getByLabel('Cells, exact value').inputValue(), cells);
  assert.equal(await page.getByLabel('Voxels, exact value').inputValue(), voxels);
  no_complaints(page);
  await page.context().close();
});

test('the missing thin end of a solid is brought back by one click', async () => {
  const page = await suite.open();
  await choose(page, 'spike.obj', 'v -0.5 -0.5 0\nv -0.5 0.5 0\nv 1 0 0\nv 0 0 4\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n');
  const notes = page.locator('.notes');
  await notes.getByText('This model is incomplete').waitFor();
  await notes.getByRole('button', {name: 'Set Cells to 48'}).click();
  await notes.getByText('This model is incomplete').waitFor({state: 'hidden'});
  assert.equal(await page.getByLabel('Cells, exact value').inputValue(), '48');
  no_complaints(page);
  await page.context().close();
});

test('a file that is no mesh is named, and the model stays', async () => {
  const page = await suite.open();
  await choose(page, 'notes.txt', 'not a mesh');
  const card = page.locator('.problem-card');
  await card.waitFor();
  assert.match(await card.textContent(), /obj|format/i);
  assert.ok(await card.getByRole('button', {name: 'Open another file'}).isVisible());
  await card.getByRole('button', {name: 'Dismiss'}).click();
  assert.ok(await tets(page) > 0);
  await page.context().close();
});

/// Far thinner than a cell.
const sheet = size => [...Array(size * size).keys()].map(k => [k % size / size, Math.floor(k / size) / size])
  .map(([x, z]) => `v ${x} ${0.15 * Math.sin(6 * x) * Math.cos(6 * z)} ${z}`).join('\n') + '\n' +
  [...Array((size - 1) ** 2).keys()].map(k => 1 + k % (size - 1) + size * Math.floor(k / (size - 1)))
    .map(v => `f ${v} ${v + 1} ${v + size + 1} ${v + size}`).join('\n');

test('notes of a model are folded away while it is complete, and stand open with a way on when it is not', async () => {
  const page = await suite.open();
  const notes = page.locator('.notes');
  const way = notes.getByRole('button').first();
  assert.ok(!await way.isVisible());
  await notes.getByText(/^\d notes?$/).click();
  assert.match(await way.textContent(), /^Set /);
  await notes.getByText(/^\d notes?$/).click();
  await drop(page, 'sheet.obj', sheet(60));
  await notes.getByText('This model is incomplete').waitFor();
  await notes.getByText(/covers .* % of the input's area/).waitFor();
  await page.setViewportSize({width: 768, height: 860});  // where the inspector is folded away
  assert.ok(!await notes.isVisible());
  assert.match(await status(page).textContent(), /incomplete: see Model in the inspector$/);
  await page.setViewportSize({width: 1400, height: 860});
  await way.click();
  await notes.getByText(/^\d notes?$/).waitFor();
  assert.match(await status(page).textContent(), /inverted$/);
  no_complaints(page);
  await page.context().close();
});
