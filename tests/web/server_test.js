import test from 'node:test';
import assert from 'node:assert/strict';
import {networkInterfaces} from 'node:os';
import {browser_tests, eventually, no_complaints, open_page, tets, tets_ready} from './support/browser.js';
import {start_server} from './support/server.js';

const suite = browser_tests();
const cells = page => page.getByLabel('Cells, exact value');

test('a lost server is noticed, and rejoined with the settings kept', async () => {
  const server = await start_server();
  const page = await open_page({browser: suite.browser, server});
  await cells(page).fill('15');
  await cells(page).press('Enter');
  const made = await eventually(() => tets(page), n => n < 6000, 'the coarser model');
  const step = async () => {
    await page.getByRole('button', {name: 'Step (.)'}).click();
    await at_step(1);
  };
  const at_step = n => page.locator('.transport .time').filter({hasText: `step ${n} `}).waitFor();
  await step();
  await server.stop();
  await page.getByText('The server does not answer; your settings are kept.').waitFor();
  const again = await start_server(server.port);
  try {
    await page.locator('.problem-card').waitFor({state: 'detached'});
    assert.equal(await cells(page).inputValue(), '15');
    assert.equal(await tets(page), made);
    await at_step(0);  // what was in view is there again
    await step();
  } finally {
    await page.context().close();
    await again.stop();
  }
});

const address = Object.values(networkInterfaces()).flat().find(({family, internal}) => family === 'IPv4' && !internal)?.address;

test('a server on another address is reached with its token, which does not stay in the address', {skip: !address && 'this machine has loopback only'}, async () => {
  const server = await start_server(0, ['--host', address, '--token', 'of this test']);
  try {
    const page = await open_page({browser: suite.browser, server}, {hash: '#token=of%20this%20test'});
    assert.ok(!page.url().includes('token'));
    await page.getByRole('button', {name: 'Step (.)'}).click();
    await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
    no_complaints(page);
    await page.context().close();

    const asked = await open_page({browser: suite.browser, server}, {wait: false});
    await asked.getByLabel('Token', {exact: true}).fill('of this test');
    await asked.getByRole('button', {name: 'Connect'}).click();
    await tets_ready(asked);
    await asked.context().close();
  } finally {
    await server.stop();
  }
});
