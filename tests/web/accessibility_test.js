import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {fileURLToPath} from 'node:url';
import {browser_tests, drop, eventually, no_complaints, status} from './support/browser.js';
import {look, look_at_rest} from './support/pixels.js';

const suite = browser_tests();
const axe = await readFile(fileURLToPath(import.meta.resolve('axe-core/axe.min.js')), 'utf8');

async function violations(page) {
  await page.evaluate(axe);
  const {violations: found} = await page.evaluate(() => globalThis.axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']}));
  return found.map(({id, nodes}) => `${id}: ${nodes.map(node => node.target.join(' ')).slice(0, 3).join(', ')}`);
}

for (const scheme of ['dark', 'light']) {
  test(`axe finds nothing in the ${scheme} page, its menus, dialogs, errors and its simulation`, async () => {
    const page = await suite.open({colorScheme: scheme});
    assert.deepEqual(await violations(page), []);
    await page.getByRole('button', {name: 'Samples'}).click();
    assert.deepEqual(await violations(page), []);
    await page.keyboard.press('Escape');
    await drop(page, 'broken.json', '{');
    await page.locator('.problem-card').waitFor();
    assert.deepEqual(await violations(page), []);
    await page.locator('.problem-card').getByRole('button', {name: 'Dismiss'}).click();
    await page.keyboard.press('?');
    assert.deepEqual(await violations(page), []);
    await page.keyboard.press('Escape');
    await page.keyboard.press('e');
    await page.getByRole('dialog').waitFor();
    assert.deepEqual(await violations(page), []);
    await page.keyboard.press('Escape');
    await page.keyboard.press('.');
    await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
    assert.deepEqual(await violations(page), []);
    no_complaints(page);
    await page.context().close();
  });
}

for (const [width, height] of [[320, 640], [768, 1024], [3840, 2160]]) {
  test(`at ${width} × ${height} nothing is cut off sideways and axe finds nothing`, async () => {
    const page = await suite.open({width, height});
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.equal(overflow, 0);
    assert.deepEqual(await violations(page), []);
    const play = page.getByRole('button', {name: 'Play (Space)'});
    await play.scrollIntoViewIfNeeded();
    assert.ok(await play.isVisible());
    await page.context().close();
  });
}

test('a problem with long ways on fits a narrow page', async () => {
  const page = await suite.open({width: 320, height: 640});
  const problem = {title: 'Empty', status: 422, code: 'empty_result', detail: 'no voxel lies inside', hint: 'try 234 cells and 468 voxels'};
  await page.route('**/api/v1/models?*', route => route.fulfill({json: {id: 'j0', status: 'failed', problem}}));
  await page.getByLabel('Cells, exact value').fill('20');
  await page.getByLabel('Cells, exact value').press('Enter');
  await page.getByRole('button', {name: 'Set Cells to 234 and Voxels to 468'}).waitFor();
  const overflow = await page.locator('.notices').evaluate(notices => notices.scrollWidth - notices.clientWidth);
  assert.equal(overflow, 0);
  no_complaints(page);
  await page.context().close();
});

test('the page can be driven by keys alone', async () => {
  const page = await suite.open();
  await page.keyboard.press('?');
  await page.getByRole('dialog', {name: 'Shortcuts and help'}).waitFor();
  await page.keyboard.press('Escape');
  await page.keyboard.press('2');
  assert.equal(await page.getByRole('button', {name: 'Voxels', exact: true}).getAttribute('aria-pressed'), 'true');
  await page.keyboard.press('y');
  assert.equal(await page.getByLabel('Clip axis').inputValue(), 'y');
  await page.keyboard.press('p');
  await status(page).filter({hasText: /^(Cell|Voxel|Triangle)/}).waitFor();
  await page.keyboard.press(' ');
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  await page.keyboard.press(' ');
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  await page.getByRole('slider', {name: 'Cells', exact: true}).focus();
  await page.keyboard.press('ArrowLeft');
  assert.equal(await page.getByLabel('Cells, exact value').inputValue(), '23');
  no_complaints(page);
  await page.context().close();
});

test('touch: one finger orbits, two zoom, one on the body drags it', async () => {
  const page = await suite.open({hasTouch: true, width: 1160, height: 640});
  const finger = await page.context().newCDPSession(page);
  const touch = (type, ...points) => finger.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
  const view = await page.locator('canvas.view').boundingBox();
  const corner = [view.x + 60, view.y + view.height - 120];
  const moves = async act => {
    const before = await look_at_rest(page);
    await act();
    await touch('touchEnd');
    await eventually(() => look(page), s => s.sum !== before.sum, 'the view moves');
  };
  await moves(async () => {
    await touch('touchStart', corner);
    await touch('touchMove', [corner[0] + 90, corner[1]]);
  });
  await moves(async () => {
    await touch('touchStart', corner, [corner[0] + 60, corner[1]]);
    await touch('touchMove', corner, [corner[0] + 160, corner[1]]);
  });
  await page.getByRole('button', {name: 'Fit (F)'}).click();
  const above = await page.locator('.view-bar').boundingBox(), below = await page.locator('.camera-bar').boundingBox();
  const middle = [view.x + view.width / 2, (above.y + above.height + below.y) / 2];  // of what the bars leave free
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  const grabs = [];
  page.on('request', request => request.url().includes('/grabs/') && grabs.push(request.method()));
  await touch('touchStart', middle);
  await touch('touchMove', [middle[0] + 60, middle[1]]);
  await eventually(() => Promise.resolve(grabs), all => all.includes('PUT'), 'grabbed');
  await touch('touchEnd');
  await eventually(() => Promise.resolve(grabs), all => all.at(-1) === 'DELETE', 'let go');
  no_complaints(page);
  await page.context().close();
});

test('touch: a second finger takes the first one off the body, and both zoom', async () => {
  const page = await suite.open({hasTouch: true, width: 1160, height: 640});
  const finger = await page.context().newCDPSession(page);
  const touch = (type, ...points) => finger.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y, id]) => ({x, y, id}))});
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  const view = await page.locator('canvas.view').boundingBox(), x = view.x + view.width / 2;
  let y = view.y + 0.3 * view.height;
  while (await page.locator('canvas.view').evaluate(canvas => canvas.style.cursor) !== 'grab') {
    assert.ok((y += 10) < view.y + view.height, 'the body stands in the middle');
    await page.mouse.move(x, y);
  }
  const grabs = [];
  page.on('request', request => request.url().includes('/grabs/') && grabs.push(request.method()));
  await touch('touchStart', [x, y, 0]);
  await touch('touchMove', [x + 30, y, 0]);
  await eventually(() => Promise.resolve(grabs), all => all.includes('PUT'), 'grabbed');
  await touch('touchStart', [x + 30, y, 0], [x + 60, y, 1]);
  await eventually(() => Promise.resolve(grabs), all => all.at(-1) === 'DELETE', 'let go');
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();  // as before the grab
  const put = grabs.length, before = await look_at_rest(page);
  await touch('touchMove', [x - 40, y, 0], [x + 130, y, 1]);
  await eventually(() => look(page), s => s.sum !== before.sum, 'the view zooms');
  await touch('touchEnd');
  assert.equal(grabs.length, put, grabs.join());
  await touch('touchStart', [x, y, 0]);
  await eventually(() => Promise.resolve(grabs), all => all.length > put, 'the next finger grabs again');
  await page.locator('[aria-label="Pause (Space)"][aria-busy=false]').dispatchEvent('click');
  const play = page.getByRole('button', {name: 'Play (Space)'});
  await play.waitFor();
  await touch('touchStart', [x, y, 0], [x + 60, y, 1]);
  await eventually(() => Promise.resolve(grabs), all => all.at(-1) === 'DELETE', 'let go again');
  await look_at_rest(page);
  assert.ok(await play.isVisible(), 'what was paused stays so');
  await touch('touchEnd');
  no_complaints(page);
  await page.context().close();
});

test('every control is reached by Tab and shows its focus', async () => {
  const page = await suite.open();
  const unreachable = await page.evaluate(() => [...document.querySelectorAll('button, input, select, summary, canvas')]
    .filter(element => element.tabIndex < 0 && !element.disabled && element.checkVisibility()).map(element => element.outerHTML.slice(0, 80)));
  assert.deepEqual(unreachable, []);
  await page.keyboard.press('Tab');
  const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
  assert.equal(outline, 'solid');
  await page.context().close();
});

test('reduced motion stops every animation', async () => {
  const page = await suite.open({reducedMotion: 'reduce'});
  const moving = await page.evaluate(() => document.getAnimations().length);
  assert.equal(moving, 0);
  await page.context().close();
});
