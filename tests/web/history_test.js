import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, drop, eventually, fact, no_complaints, status, tets} from './support/browser.js';
import {look, look_at_rest} from './support/pixels.js';

const suite = browser_tests();

const cells = page => page.getByLabel('Cells, exact value');
const type = async (field, value) => {
  await field.fill(String(value));
  await field.press('Enter');
};

test('each change is one step back and one step forward', async () => {
  const page = await suite.open();
  const before = await tets(page);
  await type(cells(page), 12);
  const coarse = await eventually(() => tets(page), n => n !== before, 'fewer cells, fewer tets');
  assert.ok(coarse < before);
  await page.getByRole('button', {name: 'Voxels', exact: true}).click();
  await page.keyboard.press('Control+z');
  assert.equal(await page.getByRole('button', {name: 'Voxels', exact: true}).getAttribute('aria-pressed'), 'false');
  await page.keyboard.press('Control+z');
  await eventually(() => tets(page), n => n === before, 'undone');
  assert.equal(await cells(page).inputValue(), '24');
  await page.keyboard.press('Control+Shift+z');
  await eventually(() => tets(page), n => n === coarse, 'done again');
  no_complaints(page);
  await page.context().close();
});

test('opening a mesh, and another scene, are steps as well', async () => {
  const page = await suite.open();
  const tree = await tets(page);
  const stiffness = page.getByLabel('Edge stiffness, exact value');
  await type(stiffness, 500);
  await page.getByLabel('Scene', {exact: true}).selectOption('drop');
  await eventually(() => stiffness.inputValue(), value => value === '3000', 'what falls is stiffer');
  await page.keyboard.press('Control+z');
  await eventually(() => stiffness.inputValue(), value => value === '500', 'the scene as it was left');
  await drop(page, 'triangles.obj', 'v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n');
  await eventually(() => fact(page, 'Vertices'), n => n === 4, 'the tetrahedron');
  const opened = await eventually(() => tets(page), n => n !== tree, 'its model');
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => tets(page), n => n === tree, 'the tree again');
  assert.equal(await fact(page, 'Vertices'), 6640);
  assert.equal(await stiffness.inputValue(), '500');
  await page.getByRole('button', {name: 'Redo'}).click();
  await eventually(() => tets(page), n => n === opened, 'the tetrahedron again');
  no_complaints(page);
  await page.context().close();
});

test('a whole drag of a slider is one step', async () => {
  const page = await suite.open();
  const slider = page.getByRole('slider', {name: 'Density', exact: true});
  await slider.scrollIntoViewIfNeeded();
  const box = await slider.boundingBox();
  const before = await slider.inputValue();
  await page.mouse.move(box.x + box.width * 0.2, box.y + box.height / 2);
  await page.mouse.down();
  for (const at of [0.3, 0.4, 0.5, 0.6]) await page.mouse.move(box.x + box.width * at, box.y + box.height / 2);
  await page.mouse.up();
  assert.notEqual(await slider.inputValue(), before);
  await page.getByRole('button', {name: 'Undo'}).click();
  assert.equal(await slider.inputValue(), before);
  assert.ok(await page.getByRole('button', {name: 'Undo'}).isDisabled());
  await page.context().close();
});

test('an orbit is one step, and fit shows everything again', async () => {
  const page = await suite.open();
  const view = page.locator('canvas.view');
  const box = await view.boundingBox();
  await page.mouse.move(box.x + 60, box.y + 500);
  await page.mouse.down();
  await page.mouse.move(box.x + 160, box.y + 520, {steps: 5});
  await page.mouse.up();
  await page.getByRole('button', {name: 'Undo'}).click();
  await status(page).filter({hasText: 'Undone: move the camera'}).waitFor();
  assert.ok(await page.getByRole('button', {name: 'Undo'}).isDisabled());
  await page.context().close();
});

test('a copied link shows the same picture in another browser: parameters, clip, camera and frame', async () => {
  const page = await suite.open();
  await type(cells(page), 14);
  await page.getByLabel('Clip axis').selectOption('x');
  await type(page.getByLabel('Gravity, exact value'), -5);
  await page.locator('canvas.view').focus();
  await page.keyboard.press('ArrowLeft');
  const made = await eventually(() => tets(page), n => n > 0 && n < 4000, 'the coarser model');
  const step = page.getByRole('button', {name: 'Step (.)'});
  const at_step = (shown, n) => shown.locator('.transport .time').filter({hasText: `step ${n} `}).waitFor();
  for (const n of [1, 2, 3]) await step.click(), await at_step(page, n);
  await page.getByRole('button', {name: 'Tets', exact: true}).click();
  await page.getByRole('button', {name: 'Share'}).click();
  await status(page).filter({hasText: /Link copied|The link stands/}).waitFor();
  const link = page.url();
  assert.ok(!link.includes(await page.locator('meta[name=isochor-token]').getAttribute('content')));
  const copy = await suite.open({hash: new URL(link).hash, wait: false});
  await at_step(copy, 3);
  await eventually(() => tets(copy), n => n === made, 'the same model');
  assert.equal(await cells(copy).inputValue(), '14');
  assert.equal(await copy.getByLabel('Clip axis').inputValue(), 'x');
  assert.equal(await copy.getByLabel('Gravity, exact value').inputValue(), '-5');
  await eventually(() => Promise.resolve(copy.url()), url => new URL(url).hash === new URL(link).hash, 'the same camera, so the same link');
  const {sum} = await look_at_rest(page);
  await eventually(() => look(copy), seen => seen.sum === sum, 'the same picture');
  no_complaints(copy);
  await page.context().close();
  await copy.context().close();
});

test('a copied link to a scene of the samples shows it, whatever a template has that it lacks', async () => {
  const page = await suite.open();
  await page.getByRole('button', {name: 'Samples'}).click();
  await page.getByRole('button', {name: 'Chain', exact: true}).click();
  const at_step = (shown, n) => shown.locator('.transport .time').filter({hasText: `step ${n} `}).waitFor();
  await at_step(page, 0);
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await at_step(page, 1);
  await page.getByRole('button', {name: 'Share'}).click();
  await status(page).filter({hasText: /Link copied|The link stands/}).waitFor();
  const {hash} = new URL(page.url());
  const copy = await suite.open({hash, wait: false});
  await at_step(copy, 1);
  await eventually(() => Promise.resolve(copy.url()), url => new URL(url).hash === hash, 'the same link');
  const {sum} = await look_at_rest(page);
  await eventually(() => look(copy), seen => seen.sum === sum, 'the same picture');
  no_complaints(copy);
  await page.context().close();
  await copy.context().close();
});

test('presets set the parameters, and the settings leave as a params file', async () => {
  const page = await suite.open();
  await page.getByRole('button', {name: 'Presets'}).click();
  await page.getByRole('button', {name: /^Coarse hull/}).click();
  assert.equal(await cells(page).inputValue(), '10');
  await page.getByRole('button', {name: 'Export', exact: true}).click();
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name: 'Save the parameters'}).click()]);
  const params = JSON.parse(await readFile(await file.path(), 'utf8'));
  assert.equal(params.cells, 10);
  assert.equal(params.largest_only, true);
  no_complaints(page);
  await page.context().close();
});
