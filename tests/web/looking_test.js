import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, eventually, fact, no_complaints, status} from './support/browser.js';
import {look, look_at_picture, look_at_rest} from './support/pixels.js';

let page;
const suite = browser_tests(async suite => page = await suite.open({width: 1240, height: 760}));

const press = name => page.getByRole('button', {name, exact: true}).click();
const seen = (passes, what) => eventually(() => look(page), passes, what);

test('each layer comes and goes', async () => {
  await press('Surface');
  await seen(s => s.sand < 500 && s.tets > 3000, 'tets alone');
  await press('Tets');
  await press('Voxels');
  await page.getByLabel('Colour voxels by').selectOption('votes');
  await seen(s => s.tets > 3000, 'voxels coloured by votes');
  for (const name of ['probability', 'density']) {
    const before_change = await look_at_rest(page);
    await page.getByLabel('Colour voxels by').selectOption(name);
    await seen(s => s.sum !== before_change.sum && s.tets > 3000, `voxels coloured by ${name}`);
  }
  await press('Voxels');
  await seen(s => s.tets < 500 && s.sand < 500, 'nothing');
  await press('Sim');
  await seen(s => s.sand > 3000, 'the start of the simulation');
  await press('Sim');
  await press('Surface');
  await press('Tets');
});

test('the clip plane moves along any axis, keeps whole cells or cuts them', async () => {
  for (const axis of ['x', 'y', 'free', 'z']) {
    await page.getByLabel('Clip axis').selectOption(axis);
    await page.getByLabel('Clip position').fill('0.9');
    const most = await look_at_rest(page);
    assert.ok(most.tets > 2000, `most cells along ${axis}`);
    await page.getByLabel('Clip position').fill('0.1');
    await seen(s => s.tets < 0.7 * most.tets, `few cells along ${axis}`);
  }
  await page.getByLabel('Clip position').fill('0.55');
  const whole = await look_at_rest(page);
  await page.getByLabel('Clip cells').selectOption('cut');
  await seen(s => s.sum !== whole.sum && s.tets > 2000, 'cut cells');
  await page.getByLabel('Clip cells').selectOption('whole');
});

test('cells explode, wireframe shows edges, colours change', async () => {
  const still = await look_at_rest(page);
  await page.getByLabel('Explode').fill('0.4');
  await seen(s => s.sum !== still.sum && s.tets > 2000, 'exploded');
  await page.getByLabel('Explode').fill('0');
  await press('Wireframe');
  await seen(s => s.tets < 0.9 * still.tets, `only edges of ${JSON.stringify(still)}`);
  await press('Wireframe');
  for (const name of ['scaled_jacobian', 'density', 'min_dihedral_deg']) {
    const before_change = await look_at_rest(page);
    await page.getByLabel('Colour tets by').selectOption(name);
    await seen(s => s.sum !== before_change.sum && s.tets > 2000, name);
  }
});

test('a range of the histogram isolates cells', async () => {
  const all = await look_at_rest(page);
  const plot = page.getByRole('group', {name: 'Histogram'});
  await plot.scrollIntoViewIfNeeded();
  const box = await plot.boundingBox();
  await page.mouse.move(box.x + box.width * 0.05, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.3, box.y + 30, {steps: 4});
  await page.mouse.up();
  await seen(s => s.tets < 0.9 * all.tets, 'fewer cells');
  await page.getByRole('button', {name: 'Show all'}).click();
  await seen(s => s.tets > 0.95 * all.tets, 'all cells');
});

test('the legend of the voxels isolates those of a range', async () => {
  for (const name of ['Tets', 'Surface', 'Voxels']) await press(name);
  await page.getByLabel('Colour voxels by').selectOption('votes');
  await page.locator('.color-panel h3', {hasText: /^Votes$/}).waitFor();
  const all = await look_at_rest(page);
  assert.ok(all.tets > 3000, 'voxels');
  await page.getByLabel('Lowest value shown').fill('25');
  await page.getByLabel('Lowest value shown').press('Enter');
  await seen(s => s.tets < 0.9 * all.tets, 'those with nearly all votes');
  assert.match(await page.locator('.bin').last().getAttribute('aria-label'), /voxels$/);
  await page.getByRole('button', {name: 'Show all'}).click();
  await seen(s => s.tets > 0.95 * all.tets, 'all voxels');
  for (const name of ['Tets', 'Surface', 'Voxels']) await press(name);
});

test('a picked cell shows its values, and P along the ray with both thresholds', async () => {
  const view = await page.locator('canvas.view').boundingBox();
  await page.mouse.click(view.x + view.width / 2 + 60, view.y + view.height / 2 - 60);
  await status(page).filter({hasText: /^(Cell|Triangle)/}).waitFor();
  await page.getByRole('img', {name: /^P along the ray/}).waitFor();
  const description = await page.getByRole('img', {name: /^P along the ray/}).getAttribute('aria-label');
  assert.match(description, /P_in .*P_subs/);
  await press('Surface');
  await page.mouse.click(view.x + view.width / 2 + 60, view.y + view.height / 2 - 60);
  await status(page).filter({hasText: /^Cell \d+, tet \d+: smallest dihedral angle/}).waitFor();
  assert.ok(await fact(page, 'Dihedral angle') >= 20);
  await press('Surface');
});

test('orbit, pan, zoom, axis views, orthographic and fit move the view', async () => {
  const view = await page.locator('canvas.view').boundingBox();
  const middle = [view.x + view.width / 2, view.y + view.height - 120];
  const changes = async (what, act) => {
    const before_change = await look_at_rest(page);
    await act();
    await seen(s => s.sum !== before_change.sum, what);
  };
  const drag = async (button, dx, dy) => {
    await page.mouse.move(...middle);
    await page.mouse.down({button});
    await page.mouse.move(middle[0] + dx, middle[1] + dy, {steps: 3});
    await page.mouse.up({button});
  };
  await changes('orbit', () => drag('left', 80, 30));
  await changes('pan', () => drag('right', 60, 20));
  await changes('zoom', () => page.mouse.wheel(0, -300));
  for (const name of ['Front', 'Right', 'Top']) await changes(name, () => press(name));
  await changes('orthographic', () => page.keyboard.press('o'));
  await changes('perspective', () => page.keyboard.press('o'));
  await changes('front again', () => press('Front'));
});

async function save_picture(from) {
  const [file] = await Promise.all([from.waitForEvent('download'), from.getByRole('button', {name: 'Save a picture of the view'}).click()]);
  return file;
}

test('the view is saved as a picture', async () => {
  assert.match((await save_picture(page)).suggestedFilename(), /\.png$/);
  no_complaints(page);
});

test('what is fitted into the view fills what the bars over it leave free', async () => {
  const narrow = await suite.open({width: 900, height: 640});  // the bar has three rows
  const corners = [...Array(8).keys()].map(i => `v ${i & 1} ${3 * (i >> 1 & 1)} ${0.2 * (i >> 2 & 1)}\n`).join('');
  const slab = `${corners}f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n`;
  await narrow.locator('input[type=file]').setInputFiles({name: 'slab.obj', mimeType: 'text/plain', buffer: Buffer.from(slab)});
  await eventually(() => fact(narrow, 'Vertices'), n => n === 8, 'the slab');
  const clip = narrow.getByRole('button', {name: 'Clip', exact: true});
  if (await clip.getAttribute('aria-pressed') === 'true') await clip.click();
  for (const look of ['Front', 'Ortho']) {
    await narrow.getByRole('button', {name: look}).click();
    const view = await narrow.locator('canvas.view').boundingBox();
    const bar = await narrow.locator('.view-bar').boundingBox(), camera = await narrow.locator('.camera-bar').boundingBox();
    const top = (bar.y + bar.height - view.y) / view.height, bottom = (camera.y - view.y) / view.height;
    const png = await readFile(await (await save_picture(narrow)).path());
    const rows = async (from, to) => (await look_at_picture(narrow, png, from, to)).tets;
    assert.equal(await rows(0, top), 0, `${look}: nothing under the upper bar`);
    assert.equal(await rows(bottom, 1), 0, `${look}: nothing under the lower bar`);
    const reach = 0.15 * (bottom - top);
    assert.ok(await rows(top, top + reach) > 0, `${look}: up to the upper bar`);
    assert.ok(await rows(bottom - reach, bottom) > 0, `${look}: down to the lower bar`);
  }
  no_complaints(narrow);
  await narrow.context().close();
});

test('the view makes room for tets that reach beyond the surface', async () => {
  const settings = {mesh: {sample: 'tree', name: 'tree'}, params: {cells: 8, density: 0.1, smoothing_iterations: 0}, view: {clip: {on: false}}};
  const narrow = await suite.open({width: 1000, height: 1200, hash: `#${Buffer.from(JSON.stringify(settings)).toString('base64url')}`});
  await narrow.getByRole('button', {name: 'Top', exact: true}).click();
  assert.ok((await look_at_rest(narrow)).tets > 2000);
  const {x, y, width, height} = await narrow.locator('canvas.view').boundingBox(), strip = 10;
  for (const left of [x, x + width - strip]) {
    const png = await narrow.screenshot({clip: {x: left, y: y + 200, width: strip, height: height - 400}});
    assert.equal((await look_at_picture(narrow, png)).tets, 0);
  }
  no_complaints(narrow);
  await narrow.context().close();
});
