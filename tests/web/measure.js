// Prints how fast the page answers, as a table: `node tests/web/measure.js [MESH…]` with ISOCHOR_BINARY set, preferably
// to a release build. Each MESH is also shown with more than a million tets.
import {chromium} from 'playwright-core';
import {basename} from 'node:path';
import {flags, open_page, status} from './support/browser.js';
import {start_server} from './support/server.js';

const note = (what, value, unit = 'ms') => {
  console.log(`${what.padEnd(64)} ${String(Math.round(value)).padStart(7)} ${unit}`);
};
const median = values => values.sort((a, b) => a - b)[values.length >> 1];

const server = await start_server();
const browser = await chromium.launch({executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: flags});

/// Milliseconds until the status line matches, counted in the page from the act on.
async function until(page, pattern, act) {
  const done = page.evaluate(source => new Promise(resolve => {
    const line = document.querySelector('footer [role=status]');
    const watch = new MutationObserver(() => {
      if (!new RegExp(source).test(line.textContent)) return;
      watch.disconnect();
      requestAnimationFrame(() => resolve(performance.now() - globalThis.measured_from));
    });
    watch.observe(line, {childList: true, characterData: true, subtree: true});
  }), pattern.source);
  await page.evaluate(() => globalThis.measured_from = performance.now());
  await act();
  return done;
}

async function measure_opening() {
  const context = await browser.newContext({viewport: {width: 1440, height: 900}});
  const page = await context.newPage();
  await page.addInitScript(() => {
    const report = new MutationObserver(() => {
      const line = document.querySelector('footer [role=status]');
      if (/triangles?$/.test(document.querySelector('.stages .stage-state')?.textContent ?? '')) globalThis.surface_at ??= performance.now();
      if (/tets in/.test(line?.textContent ?? '')) globalThis.tets_at ??= performance.now();
    });
    report.observe(document, {childList: true, characterData: true, subtree: true});
    // The tree's surface is the one indexed mesh of so many corners; the frame after its first drawing shows it.
    const {prototype} = WebGL2RenderingContext, {drawElements} = prototype;
    prototype.drawElements = function(mode, count, ...rest) {
      if (count > 10000) requestAnimationFrame(() => globalThis.drawn_at ??= performance.now());
      return drawElements.call(this, mode, count, ...rest);
    };
  });
  await page.goto(server.url);
  await status(page).filter({hasText: /tets in/}).waitFor();
  const [surface, drawn, tets] = await page.evaluate(() => [globalThis.surface_at, globalThis.drawn_at, globalThis.tets_at]);
  note('first visit: the input is known', surface);
  note('first visit: the surface is drawn', drawn);
  note('first visit: tets', tets);
  await context.close();
}

async function measure_tuning(page, name) {
  for (const [title, slider] of [['P_in', 'P_in as distance'], ['cells', 'Cells'], ['density', 'Density']]) {
    const previews = [], fulls = [];
    for (let k = 0; k < 5; ++k) {
      const set = (event, by) => page.getByRole('slider', {name: slider, exact: true}).evaluate((input, [type, step]) => {
        input.value = Number(input.value) + step * Number(input.step);
        input.dispatchEvent(new Event(type, {bubbles: true}));
      }, [event, by]);
      previews.push(await until(page, /^Preview: [\d,]+ tets/, () => set('input', k % 2 ? -1 : 1)));
      fulls.push(await until(page, /^[\d,]+ tets/, () => set('change', 0)));
    }
    note(`${name}, ${title}: preview after a slider's move (median of 5)`, median(previews));
    note(`${name}, ${title}: full result after its release (median of 5)`, median(fulls));
  }
}

async function measure_large(page, name) {
  const took = await until(page, /^[\d,]+ tets/, async () => {
    await page.getByLabel('Voxels, exact value').fill('320');
    await page.getByLabel('Voxels, exact value').press('Enter');
    await page.getByLabel('Cells, exact value').fill('120');
    await page.getByLabel('Cells, exact value').press('Enter');
    await status(page).filter({hasText: /^[\d,]{7,} tets/}).waitFor({timeout: 120000});
  });
  const tets = Number((await page.locator('dt', {hasText: /^Tets$/}).first().locator('xpath=following-sibling::dd[1]').textContent()).replaceAll(',', ''));
  note(`${name}: tets shown`, tets, 'tets');
  note(`${name}: from the change to the screen`, took);
  await page.locator('canvas.view').focus();
  note(`${name}: a frame while orbiting`, await frame_time(page,
    "document.querySelector('canvas.view').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft', bubbles: true}))"));
  note(`${name}: a frame while the clip moves`, await frame_time(page,
    "const s = document.querySelector('[aria-label=\"Clip position\"]'); s.value = 0.4 + 0.005 * (k % 40); s.dispatchEvent(new Event('input'))"));
}

/// Milliseconds a frame over two seconds of acting in each: the view sets one fence a picture that it draws.
const frame_time = (page, act) => page.evaluate(async source => {
  const step = new Function('k', source), {prototype} = WebGL2RenderingContext, {fenceSync} = prototype;
  let drawn = 0;
  prototype.fenceSync = function(...args) {
    ++drawn;
    return fenceSync.apply(this, args);
  };
  const from = performance.now();
  for (let k = 0; performance.now() - from < 2000; ++k) {
    step(k);
    await new Promise(requestAnimationFrame);
  }
  prototype.fenceSync = fenceSync;
  return 2000 / drawn;
}, act);

/// Frames a second of a live simulation that reach the page, decoded by its own reader, over four seconds.
async function measure_stream(page) {
  const {vertices, rate, dropped} = await page.evaluate(async () => {
    const headers = {Authorization: `Bearer ${document.querySelector('meta[name=isochor-token]').content}`, 'Content-Type': 'application/json'};
    const body = {type: 'deformable', edge_stiffness: 100, diagonal_stiffness: 100,
      lattice: {cells: [26, 26, 26], cell_size: 1 / 26, origin: [0, 1, 0]}};
    const made = await fetch('/api/v1/simulations?state=playing&wait_ms=10000', {method: 'POST', headers,
      body: JSON.stringify({duration: null, gravity: [0, 0, 0], bodies: [body]})});
    const {id, frames} = await made.json();
    const worker = new Worker('/wire/stream_worker.js', {type: 'module'});
    const seen = [];
    worker.addEventListener('message', ({data: {line}}) => line?.type === 'frame' && seen.push([performance.now(), line]));
    worker.postMessage({task: 'follow', url: frames, headers, generation: 0});
    while (!seen.length) await new Promise(resolve => setTimeout(resolve, 20));
    const first = seen.length, from = performance.now();
    await new Promise(resolve => setTimeout(resolve, 4000));
    const counted = seen.slice(first).filter(([at]) => at <= from + 4000);
    worker.terminate();
    await fetch(`/api/v1/simulations/${id}`, {method: 'DELETE', headers});
    const lines = counted.map(([, line]) => line);
    return {vertices: lines[0].bodies[0].positions.length / 3, rate: counted.length / 4,
      dropped: lines.at(-1).dropped - lines[0].dropped};
  });
  note('stream: vertices of a frame', vertices, 'vertices');
  note('stream: frames that reach the page, decoded', rate, 'a second');
  note('stream: frames dropped in four seconds', dropped, 'frames');
}

try {
  await measure_opening();
  const page = await open_page({browser, server});
  await measure_stream(page);
  await measure_tuning(page, 'tree');
  for (const file of process.argv.slice(2)) {
    const name = basename(file);
    await until(page, /^[\d,]+ tets/, () => page.locator('input[type=file]').setInputFiles(file));
    await measure_tuning(page, name);
    await measure_large(page, name);
  }
} finally {
  await browser.close();
  await server.stop();
}
