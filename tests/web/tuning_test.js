import test from 'node:test';
import assert from 'node:assert/strict';
import {browser_tests, eventually, fact, move_slider, no_complaints, status, tets, tets_ready} from './support/browser.js';
import {at_rest} from './support/pixels.js';

let page;
browser_tests(async suite => page = await suite.open({width: 1240, height: 760}));

const badge = stage => page.getByRole('region', {name: stage, exact: true}).locator('.stage-state');
const exact = name => page.getByLabel(`${name}, exact value`);

test('every parameter of the schema has a control with a name, an explanation and its value', async () => {
  const schema = await page.evaluate(async () => (await fetch('./api/v1/parameters')).json());
  for (const [name, {title, description}] of Object.entries(schema.properties)) {
    const field = page.locator(`[data-path="params.${name}"]`);
    assert.equal(await field.count(), 1, name);
    assert.equal(await field.locator('label').textContent(), title);
    assert.equal(await field.getByRole('tooltip', {includeHidden: true}).textContent(), description);
  }
  const voxels = page.getByRole('slider', {name: 'Voxels', exact: true});
  const tip = page.locator('[data-path="params.voxels"] .tip');
  await voxels.focus();
  await page.keyboard.press('Tab');
  await page.keyboard.press('Shift+Tab');
  await eventually(() => tip.evaluate(element => getComputedStyle(element).opacity), opacity => opacity === '1', 'the tooltip of the focused field');
  await page.keyboard.press('Escape');
  await eventually(() => tip.evaluate(element => getComputedStyle(element).visibility), seen => seen === 'hidden', 'gone on Escape');
});

test('a moving slider is followed by previews, its release by the full model', async () => {
  const before = await tets(page);
  const asked = [];
  page.on('request', request => request.url().includes('/models?') && asked.push(request.postDataJSON()));
  const slider = page.getByRole('slider', {name: 'Cells', exact: true});
  await slider.scrollIntoViewIfNeeded();
  const box = await slider.boundingBox();
  const preview = status(page).filter({hasText: /^Preview: [\d,]+ tets in/}).waitFor();
  await page.mouse.move(box.x + box.width * 0.08, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.05, box.y + box.height / 2, {steps: 3});
  await preview;
  await badge('Smoothing').filter({hasText: 'stale'}).waitFor();  // for a preview has no embedding
  await page.mouse.up();
  await tets_ready(page);
  await badge('Smoothing').filter({hasText: / m?s$/}).waitFor();
  assert.ok(await tets(page) < before);
  const most = await fact(page, 'Off the pseudo volume'), mean = await fact(page, 'On average');
  assert.ok(0 < mean && mean < most && most < 1, `${mean} and ${most} diagonals`);
  assert.ok(asked.slice(0, -1).every(({quality}) => quality === 'preview'));
  assert.equal(asked.at(-1).quality, 'full');
});

test('only the stages after a change are made anew, and the others say that they were kept', async () => {
  await exact('Smoothing iterations').fill('4');
  await exact('Smoothing iterations').press('Enter');
  for (const stage of ['Pseudo volume', 'Lattice']) await badge(stage).filter({hasText: 'kept'}).waitFor();
  await badge('Smoothing').filter({hasText: / m?s$/}).waitFor();
  const reset = page.getByRole('button', {name: 'Reset Smoothing iterations'});
  await reset.click();
  assert.equal(await exact('Smoothing iterations').inputValue(), '2');
  assert.ok(await reset.isHidden());
});

test('what is typed into a whole number is rounded to one', async () => {
  await exact('Smoothing iterations').fill('2.6');
  await exact('Smoothing iterations').press('Enter');
  await exact('Smoothing step').focus();
  assert.equal(await exact('Smoothing iterations').inputValue(), '3');
  await badge('Smoothing').filter({hasText: / m?s$/}).waitFor();
  await page.getByRole('button', {name: 'Reset Smoothing iterations'}).click();
  await tets_ready(page);
  assert.equal(await page.locator('.problem-card').count(), 0);
});

test('a preview asks for the next and begins its picture before the panels are written, which keep their parts', async () => {
  const bin = page.locator('.bin').nth(3);
  const before = await bin.elementHandle(), made_before = await tets(page);
  await at_rest(page);
  const order = await page.getByRole('slider', {name: 'Cells', exact: true}).evaluate(async slider => {
    const line = document.querySelector('footer [role=status]'), {prototype} = WebGL2RenderingContext, {fenceSync} = prototype, {postMessage} = Worker.prototype;
    const seen = [];
    Worker.prototype.postMessage = function(message, ...rest) {
      if (message.task === 'make_preview') seen.push('asked');
      return postMessage.call(this, message, ...rest);
    };
    prototype.fenceSync = function(...args) {
      seen.push('picture');
      return fenceSync.apply(this, args);
    };
    const told = new Promise(resolve => new MutationObserver((_, observer) => {
      if (!line.textContent.startsWith('Preview')) return;
      seen.push('told');
      observer.disconnect();
      resolve();
    }).observe(line, {childList: true}));
    for (const value of [22, 24]) {  // the second waits for the first
      slider.value = value;
      slider.dispatchEvent(new Event('input'));
    }
    await told;
    Object.assign(Worker.prototype, {postMessage});
    Object.assign(prototype, {fenceSync});
    return seen;
  });
  assert.deepEqual(order, ['asked', 'asked', 'picture', 'told']);
  assert.ok(await bin.evaluate((node, same) => node === same, before));
  await page.getByRole('slider', {name: 'Cells', exact: true}).dispatchEvent('change');
  await tets_ready(page);
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => tets(page), n => n === made_before, 'the model as it was');
});

test('where previews are long in coming, coarser ones are asked for, and an empty one is no problem', async () => {
  const before = await tets(page), path = '**/api/v1/models?*', cells = [];
  let empty = false;
  await page.route(path, async route => {
    const {quality, preview_cells} = route.request().postDataJSON();
    if (quality !== 'preview') return route.continue();
    cells.push(preview_cells);
    await new Promise(resolve => setTimeout(resolve, 100));
    const problem = {title: 'Empty', status: 422, code: 'empty_result', detail: 'no voxel lies inside'};
    return empty ? route.fulfill({json: {id: 'j0', status: 'failed', problem}}) : route.continue();
  });
  for (let turn = 0; cells.at(-1) !== 12; ++turn) {
    assert.ok(turn < 8, cells.join());
    const answered = page.waitForResponse(path);
    await move_slider(page, 'Cells', turn % 2 ? 20 : 22);
    await answered;
    await at_rest(page);
  }
  empty = true;
  const asked = cells.length;
  await move_slider(page, 'Cells', 18);
  await eventually(() => Promise.resolve(cells.length), n => n > asked, 'the empty preview');
  await badge('Lattice').filter({hasText: 'stale'}).waitFor();
  assert.equal(await page.locator('.problem-card').count(), 0);
  await page.unroute(path);
  await page.getByRole('slider', {name: 'Cells', exact: true}).dispatchEvent('change');
  await tets_ready(page);
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => tets(page), n => n === before, 'the model as it was');
});

test('a preview that is not wanted any more when its job is told of is cancelled', async () => {
  const before = await tets(page), path = '**/api/v1/models?*';
  let let_answer, answer_held;
  const answered = new Promise(resolve => let_answer = resolve), held = new Promise(resolve => answer_held = resolve);
  await page.route(path, async route => {
    if (route.request().postDataJSON().quality !== 'preview') return route.continue();
    const response = await route.fetch(), job = await response.json();
    answer_held(job);
    await answered;
    await route.fulfill({response, status: 202, json: {...job, status: 'running'}});
  });
  const cancelled = page.waitForRequest(request => request.method() === 'DELETE' && request.url().includes('/jobs/'));
  await move_slider(page, 'Cells', 26);
  const {id} = await held;
  await page.getByRole('slider', {name: 'Cells', exact: true}).dispatchEvent('change');
  let_answer();
  assert.ok((await cancelled).url().endsWith(`/jobs/${id}`));
  await eventually(() => tets(page), n => n !== before, 'the whole model');
  await page.unroute(path);
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => tets(page), n => n === before, 'the model as it was');
});

/// From now on jobs go on for ever, as far as the page is told.
const make_jobs_endless = () => page.route('**/api/v1/jobs/*', async route => {
  const response = await route.fetch();
  await route.fulfill({response, json: {...await response.json(), status: 'running'}});
});

test('long work shows its progress and is cancelled, and the last model stays', async () => {
  await status(page).filter({hasText: /^[\d,]+ tets in/}).waitFor();
  const before = await tets(page);
  await make_jobs_endless();
  await exact('Voxels').fill('512');
  await exact('Voxels').press('Enter');
  await page.getByRole('progressbar', {name: 'Progress', exact: true}).waitFor();
  await page.getByRole('button', {name: 'Cancel', exact: true}).click();
  await status(page).filter({hasText: 'Cancelled; the last model stays'}).waitFor();
  assert.equal(await tets(page), before);
  no_complaints(page);
});
