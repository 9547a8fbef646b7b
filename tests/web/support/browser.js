import {after, before} from 'node:test';
import assert from 'node:assert/strict';
import {chromium} from 'playwright-core';
import {count_pictures} from './pixels.js';
import {start_server} from './server.js';

export const flags = ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

// Milliseconds until what does not come counts as not coming, on a machine that others starve as well; ISOCHOR_SLOWNESS
// tells how many times slower than a release build the server is.
const patience = 120000 * Number(process.env.ISOCHOR_SLOWNESS ?? 1);

// SwiftShader behind a software compositor reads pixels back and says so; a person's browser does not.
const of_this_driver = text => text.includes('GPU stall due to ReadPixels');

/// A server and a browser for the tests of one file; open(options) gives a page on it. prepare(tests) runs before the
/// first test.
export function browser_tests(prepare = () => {}) {
  const tests = {};
  before(async () => {
    tests.server = await start_server();
    tests.browser = await chromium.launch({executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: flags});
    await prepare(tests);
  });
  after(async () => {
    await tests.browser?.close();
    await tests.server?.stop();
  });
  tests.open = options => open_page(tests, options);
  return tests;
}

/// The page on the sample tree, or on what the hash says, once its tets are there. page.complaints collects what the
/// console said; a test ends with no_complaints(page). prepare(page) runs before it goes there.
export async function open_page({browser, server, prepare = () => {}}, {width = 1400, height = 860, hash = '', wait = true, ...context} = {}) {
  const made = await browser.newContext({viewport: {width, height}, colorScheme: 'dark', ...context});
  made.setDefaultTimeout(patience);
  await made.addInitScript(count_pictures);
  const page = await made.newPage();
  page.complaints = [];
  page.on('console', message => {
    if (['error', 'warning'].includes(message.type()) && !of_this_driver(message.text())) page.complaints.push(message.text());
  });
  page.on('pageerror', error => page.complaints.push(error.stack));
  await prepare(page);
  await page.goto(server.url + hash);
  if (wait) await tets_ready(page);
  return page;
}

export const status = page => page.locator('footer [role=status]');
export const tets_ready = page => status(page).filter({hasText: /^[\d,]+ tets in/}).waitFor();
export const no_complaints = page => assert.deepEqual(page.complaints, []);

/// The number in a row of the inspector's or the stages' facts.
export async function fact(page, name) {
  const text = await page.locator('dt', {hasText: new RegExp(`^${name}$`)}).first().locator('xpath=following-sibling::dd[1]').textContent();
  const [, mantissa, exponent = '0'] = /^([\d.-]+)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/.exec(text.replaceAll(',', '').replace('−', '-')) ?? [];
  return Number(`${mantissa}e${[...exponent].map(c => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'.includes(c) ? '-0123456789'['⁻⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c)] : c).join('')}`);
}

export const tets = page => fact(page, 'Tets');

/// The newest run as the server has it; ids count upwards.
export const newest_run = page => page.evaluate(async () => {
  const {simulations} = await (await fetch('./api/v1/simulations')).json();
  const age = ({id}) => Number(id.slice(1));
  return simulations.sort((a, b) => age(a) - age(b)).at(-1);
});

/// A slider as a person holds it: previews follow.
export const move_slider = (page, name, value) => page.getByRole('slider', {name, exact: true}).evaluate((slider, moved) => {
  slider.value = moved;
  slider.dispatchEvent(new Event('input'));
}, value);

/// Moves a slider and lets it go. The page then has a preview until release(), which lets it ask for the whole model.
export async function hold_at_preview(page, name, value) {
  let release;
  const released = new Promise(resolve => release = resolve);
  await page.route('**/api/v1/models?*', async route => {
    if (route.request().postDataJSON().quality === 'full') await released;
    await route.continue();
  });
  await move_slider(page, name, value);
  await status(page).filter({hasText: /^Preview: /}).waitFor();
  await page.getByRole('slider', {name, exact: true}).dispatchEvent('change');
  return release;
}

/// Waits until read() gives something that passes; returns it.
export async function eventually(read, passes, what) {
  const end = Date.now() + patience;
  for (;;) {
    const value = await read();
    if (passes(value)) return value;
    if (Date.now() > end) assert.fail(`${what}: still ${JSON.stringify(value)}`);
    await new Promise(resolve => setTimeout(resolve, 50));
  }
}

/// A file dropped anywhere on the page.
export async function drop(page, name, text) {
  const transfer = await page.evaluateHandle(([file, content]) => {
    const made = new DataTransfer();
    made.items.add(new File([content], file));
    return made;
  }, [name, text]);
  await page.dispatchEvent('body', 'dragenter', {dataTransfer: transfer});
  assert.ok(await page.getByText('Drop a mesh, a recording or a scene').isVisible());
  await page.dispatchEvent('body', 'drop', {dataTransfer: transfer});
}
