import test from 'node:test';
import assert from 'node:assert/strict';
import {browser_tests, eventually, no_complaints, open_page, tets, tets_ready} from './support/browser.js';
import {look} from './support/pixels.js';

const suite = browser_tests();
const {open} = suite;

test('the first visit shows the sample tree and its tets half open, and says nothing in the console', async () => {
  const page = await open();
  assert.ok(await tets(page) > 500);
  assert.equal(await page.getByRole('button', {name: 'Clip', exact: true}).getAttribute('aria-pressed'), 'true');
  const seen = await eventually(() => look(page), s => s.tets > 5000 && s.sand > 3000, 'tets and surface seen');
  await page.getByRole('button', {name: 'Clip', exact: true}).click();
  await eventually(() => look(page), s => s.tets > 1.2 * seen.tets, 'the clip had hidden tets');
  assert.equal(await page.locator('dialog').count(), 0);
  no_complaints(page);
  await page.context().close();
});

test('the page comes in a handful of files, and its first model is under way before anything is laid out', async () => {
  /// All that is drawn waits for the parameters: they come once the sample is known, which is soon.
  const prepare = async made => {
    await made.addInitScript(() => {
      const {fetch} = globalThis;
      globalThis.fetch = (url, ...rest) => {
        if (String(url).includes('/models?')) globalThis.laid_out_first ??= Boolean(document.querySelector('header'));
        return fetch(url, ...rest);
      };
    });
    const known = made.waitForResponse('**/meshes?*').then(response => response.finished());
    await made.route('**/api/v1/parameters', async route => (await known, route.continue()));
  };
  const page = await open_page({...suite, prepare}, {wait: false});
  const asked = await page.evaluate(() => performance.getEntriesByType('resource').map(({name}) => new URL(name).pathname));
  assert.ok(asked.filter(path => /\.(js|css)$/.test(path)).length <= 4, asked.join());
  await tets_ready(page);
  const at = await page.evaluate(() => {
    const model = performance.getEntriesByType('resource').find(({name}) => name.includes('/models?'));
    return {model: model.startTime, drawn: performance.getEntriesByName('first-contentful-paint')[0].startTime};
  });
  assert.ok(at.model < at.drawn, JSON.stringify(at));
  assert.equal(await page.evaluate(() => globalThis.laid_out_first), false);
  await page.context().close();
});

test('the first press on play moves the tree', async () => {
  const page = await open();
  await page.getByRole('button', {name: 'Play (Space)'}).click();
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  const first = await eventually(() => look(page), s => s.sand > 3000, 'the skin is seen');
  await eventually(() => look(page), s => s.sum !== first.sum, 'the tree moves');
  await eventually(() => page.locator('.transport .time').textContent(), text => Number.parseFloat(text) > 0.3, 'time goes on');
  no_complaints(page);
  await page.context().close();
});
