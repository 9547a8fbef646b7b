import test from 'node:test';
import assert from 'node:assert/strict';
import http from 'node:http';
import {browser_tests, drop, eventually, newest_run, open_page, status, tets, tets_ready} from './support/browser.js';
import {start_server} from './support/server.js';

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
  'an empty recording': ['empty.ndjson', '', /empty\.ndjson cannot be read as a recording/],
  'a scene without its parts': ['scene.json', '{"name": "x", "bodies": [{"name": "a", "type": "deformable"}]}', /bod|mesh|lattice/],
};

for (const [name, [file, text, says]] of Object.entries(files))
  test(`${name}: what, where, and a way on, and all that was there stays`, async () => {
    const page = await suite.open({width: 1160, height: 640});
    await drop(page, file, text);
    await way_on(page, says, /^(Open another file|Undo the last change)$/);
    assert.equal(await page.getByRole('button', {name: 'Tets', exact: true}).getAttribute('aria-pressed'), 'true');
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

const small = {width: 1160, height: 640};
const step = page => page.getByRole('button', {name: 'Step (.)'}).click();
const at_step = (page, n) => page.locator('.transport .time').filter({hasText: `step ${n} `}).waitFor();
const exact = async (page, name, value) => {
  await page.getByLabel(`${name}, exact value`, {exact: true}).fill(value);
  await page.getByLabel(`${name}, exact value`, {exact: true}).press('Enter');
};

/// Deletes all resources of a kind, as another page on the same server may.
const remove = (page, kind) => page.evaluate(async name => {
  const headers = {Authorization: `Bearer ${sessionStorage.getItem('isochor-token')}`};
  const all = (await (await fetch(`./api/v1/${name}`)).json())[name];
  for (const {id} of all) await fetch(`./api/v1/${name}/${id}`, {method: 'DELETE', headers});
}, kind);

test('over the memory allowed: the largest setting that fits, one click away', async t => {
  const server = await start_server(0, ['--memory', '0.3']);
  t.after(() => server.stop());
  const page = await open_page({browser: suite.browser, server}, small);
  await exact(page, 'Voxels', '512');
  await way_on(page, /512 voxels and \d+ cells may need [\d,]+ MiB, but 307 MiB are allowed/, /^Set Voxels to \d+$/);
  await page.getByRole('region', {name: 'Pseudo volume', exact: true}).locator('.stage-state.fresh').waitFor();
  await page.context().close();
});

test('a model, a mesh and a run that the server gave up are made again by one click', async () => {
  const page = await suite.open(small);
  await remove(page, 'models');
  await page.keyboard.press('2');
  await status(page).filter({hasText: 'Voxels on'}).waitFor();
  await way_on(page, /[Mm]odel '.*' was deleted, or gave way/, 'Mesh it again');
  await tets_ready(page);
  const before = await tets(page);
  await remove(page, 'meshes');
  await exact(page, 'Cells', '30');
  await way_on(page, /[Mm]esh '.*' was deleted, or gave way/, 'Open it again');
  await eventually(() => tets(page), n => n > before, 'tets of 30 cells');  // a later model would make the run anew
  await step(page);
  await at_step(page, 1);
  await remove(page, 'simulations');
  await step(page);
  await way_on(page, /[Ss]imulation '.*' was deleted, or gave way/, 'Start the run again');
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  await page.context().close();
});

test('too many streams: the card says so, and the run is joined by one click when some have ended', async () => {
  const page = await suite.open(small);
  await step(page);
  await at_step(page, 1);
  const {id} = await newest_run(page);
  const viewers = await Promise.all(Array.from({length: 255}, () => new Promise(resolve => {
    const request = http.get(`${suite.server.url}api/v1/simulations/${id}/frames`, {agent: false}, response => response.resume().on('error', () => {}) && resolve(request));
    request.on('error', () => {});
  })));
  const other = await suite.open(small);
  await step(other);
  await card(other).waitFor();
  for (const viewer of viewers) viewer.destroy();
  await eventually(async () => (await (await fetch(`${suite.server.url}api/v1/simulations/${id}`)).json()).viewers, n => n === 1, 'the server has noticed');
  await way_on(other, /256 streams are open/, 'Try again');
  await step(other);
  await at_step(other, 2);
  await page.context().close();
  await other.context().close();
});

test('a server that is busy is asked once more, then by one click', async () => {
  const page = await suite.open(small);
  const before = await tets(page);
  let asked = 0;
  await page.route('**/api/v1/models?*', route => ++asked <= 2 ? route.fulfill({status: 503, contentType: 'application/problem+json',
    headers: {'Retry-After': '0'}, body: JSON.stringify({status: 503, code: 'busy', title: 'Service Unavailable', detail: 'too many requests are waiting', hint: 'try again'})}) : route.continue());
  await exact(page, 'Cells', '28');
  await way_on(page, /Too many requests are waiting/, 'Try again');
  await eventually(() => tets(page), n => n > before, 'tets of 28 cells');
  assert.equal(asked, 3);
  await page.context().close();
});

test('without WebGL a sentence stands in place of the view, and all else works', async () => {
  const page = await suite.browser.newPage();
  await page.addInitScript(() => HTMLCanvasElement.prototype.getContext = () => null);
  await page.goto(suite.server.url);
  await tets_ready(page);
  await page.getByText('No picture: this browser offers no WebGL 2').waitFor();
  await step(page);
  await at_step(page, 1);
  await page.close();
});
