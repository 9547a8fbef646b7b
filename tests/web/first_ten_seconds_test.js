import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {posix} from 'node:path';
import {browser_tests, eventually, no_complaints, tets} from './support/browser.js';
import {look} from './support/pixels.js';

const {open} = browser_tests();
const web = new URL('../../web/', import.meta.url);

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

/// The modules that a module imports, directly or not, by their paths in web/.
async function imports_of(path, found = new Set()) {
  const text = await readFile(new URL(path, web), 'utf8');
  for (const [, relative] of text.matchAll(/from '(\.[^']+)'/g)) {
    const imported = posix.join(posix.dirname(path), relative);
    if (imported.startsWith('vendor/') || found.has(imported)) continue;
    found.add(imported);
    await imports_of(imported, found);
  }
  return found;
}

test('the page preloads every module that it imports, so that none waits for another', async () => {
  const html = await readFile(new URL('index.html', web), 'utf8');
  const preloaded = [...html.matchAll(/modulepreload" href="([^"]+)"/g)].map(([, path]) => path).filter(path => !path.startsWith('vendor/'));
  assert.deepEqual(preloaded.sort(), [...await imports_of('main.js')].sort());
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
