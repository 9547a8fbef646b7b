import test, {after} from 'node:test';
import assert from 'node:assert/strict';
import {browser_tests, drop, eventually, fact, no_complaints, open_page, tets, tets_ready} from './support/browser.js';
import {nginx, start_proxy} from './support/proxy.js';
import {start_server} from './support/server.js';

// Reached from elsewhere: over TLS, through a proxy that is set up as the README says.
const skip = !nginx && 'nginx is not installed';
const far = {};
const suite = browser_tests(async () => {
  if (skip) return;
  far.server = await start_server(0, ['--host', '0.0.0.0', '--token', 'of this test']);
  far.proxy = await start_proxy(far.server.port);
});
after(async () => {
  await far.proxy?.stop();
  await far.server?.stop();
});

const opened = options => open_page({browser: suite.browser, server: far.proxy}, {width: 1160, height: 640, ignoreHTTPSErrors: true, ...options});
const link = '#token=of%20this%20test';
const cube = `${[...Array(8).keys()].map(i => `v ${i & 1} ${i >> 1 & 1} ${i >> 2 & 1}`).join('\n')}
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n`;

test('through nginx: tets, a visit again, each frame when it is made, and a large file', {skip}, async () => {
  const page = await opened({hash: link});
  await page.reload();
  await tets_ready(page);
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  const tree = await tets(page);
  await drop(page, 'cube.obj', cube + '# more than a proxy takes by itself\n'.repeat(60000));
  await eventually(() => fact(page, 'Vertices'), n => n === 8, 'the report of the cube');
  await eventually(() => tets(page), n => n !== tree, 'the model of the cube');
  no_complaints(page);
  await page.context().close();
});

test('the address with the token works in the tab that has just asked for it', {skip}, async () => {
  const page = await opened({wait: false});
  await page.getByLabel('Token', {exact: true}).waitFor();
  await page.goto(far.proxy.url + link);
  await tets_ready(page);
  assert.ok(!page.url().includes('token'));
  await page.context().close();
});
