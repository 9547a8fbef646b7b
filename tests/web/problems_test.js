import test from 'node:test';
import assert from 'node:assert/strict';
import {browser_tests, drop, status, tets, tets_ready} from './support/browser.js';

const suite = browser_tests();
const card = page => page.locator('.problem-card');

/// The card says what and where, offers a way on, and after one click the page works again.
async function way_on(page, says, action) {
  await card(page).waitFor();
  assert.match(await card(page).textContent(), says);
  await card(page).getByRole('button', {name: action}).first().click();
  await card(page).waitFor({state: 'detached'});
}

const files = {
  'params that are no JSON': ['broken.json', '{"cells": 12', /broken\.json cannot be read/],
  'JSON without settings': ['other.json', '{"colour": "red"}', /other\.json holds neither parameters nor the bodies/],
  'a recording that is none': ['broken.ndjson', '{"type": "hello"\nnothing', /broken\.ndjson cannot be read as a recording/],
  'a scene without its parts': ['scene.json', '{"name": "x", "bodies": [{"name": "a", "type": "deformable"}]}', /bod|mesh|lattice/],
};

for (const [name, [file, text, says]] of Object.entries(files))
  test(`${name}: what, where, and the sample one click away`, async () => {
    const page = await suite.open({width: 1160, height: 640});
    await drop(page, file, text);
    await way_on(page, says, /^(Back to the sample tree|Undo the last change)$/);
    await page.getByRole('button', {name: 'Step (.)'}).click();
    await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
    await page.context().close();
  });

test('an address that is damaged opens the sample', async () => {
  const page = await suite.open({hash: '#not-a-link', width: 1160, height: 640});
  assert.ok(await tets(page) > 0);
  await status(page).waitFor();
  await page.context().close();
});

test('a link to a mesh that the server does not know says so, and the sample is one click away', async () => {
  const hash = `#${Buffer.from(JSON.stringify({mesh: {sample: null, id: 'mesh-unknown', name: 'gone.obj'}})).toString('base64url')}`;
  const page = await suite.open({hash, wait: false, width: 1160, height: 640});
  await way_on(page, /mesh/, 'Back to the sample tree');
  await tets_ready(page);
  await page.context().close();
});
