// Prints how fast the page answers, as a table: `node tests/web/measure.js [--stream] [MESH…]` with ISOCHOR_BINARY set,
// preferably to a release build. Each MESH is also shown with more than a million tets. --stream: only the live stream.
import {chromium} from 'playwright-core';
import {basename} from 'node:path';
import {flags, open_page, status} from './support/browser.js';
import {start_server} from './support/server.js';

const note = (what, value, unit = 'ms') => {
  console.log(`${what.padEnd(64)} ${String(Math.round(value)).padStart(7)} ${unit}`);
};
const median = values => values.toSorted((a, b) => a - b)[values.length >> 1];
const note_all = (what, values) => {
  note(`${what} (median of ${values.length})`, median(values));
  note(`${what} (worst)`, Math.max(...values));
};

const server = await start_server();
const browser = await chromium.launch({executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: flags});

/// In the page: picture_begun() is the moment when the graphics processor has drawn the picture that the view begins in
/// this task, or else the next.
function watch_pictures() {
  const {prototype} = WebGL2RenderingContext, {fenceSync} = prototype;  // the view sets one fence a picture
  const waiting = [];
  let begun = null;
  globalThis.picture_begun = () => begun ?? new Promise(resolve => waiting.push(resolve));
  globalThis.pictures = 0;
  const drawn = (gl, fence) => new Promise(resolve => {
    const poll = () => {
      if (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return void setTimeout(poll);
      gl.deleteSync(fence);
      resolve(performance.now());
    };
    setTimeout(poll);
  });
  prototype.fenceSync = function(...args) {
    ++globalThis.pictures;
    const own = begun = drawn(this, fenceSync.apply(this, args));
    for (const tell of waiting.splice(0)) tell(own);
    const {port1, port2} = new MessageChannel();
    port1.onmessage = () => {
      if (begun === own) begun = null;
      port1.close();
    };
    port2.postMessage(null);
    return fenceSync.apply(this, args);
  };
}

/// Milliseconds from the act until what the status line tells of in the pattern's words is drawn.
async function until(page, pattern, act) {
  const done = page.evaluate(source => new Promise(resolve => {
    const line = document.querySelector('footer [role=status]');
    const watch = new MutationObserver(async () => {
      if (!new RegExp(source).test(line.textContent)) return;
      watch.disconnect();
      resolve(await globalThis.picture_begun() - globalThis.measured_from);
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
  await page.waitForTimeout(3000);  // the browser itself is still starting
  await page.goto(server.url);
  await status(page).filter({hasText: /tets in/}).waitFor();
  const [surface, drawn, tets] = await page.evaluate(() => [globalThis.surface_at, globalThis.drawn_at, globalThis.tets_at]);
  note('first visit: the input is known', surface);
  note('first visit: the surface is drawn', drawn);
  note('first visit: tets', tets);
  await context.close();
}

const sliders = {P_in: 'P_in as distance', P_subs: 'P_subs as distance', cells: 'Cells', density: 'Density', smoothing: 'Smoothing iterations'};

/// Each step of a slider waits for the picture of its preview, its release for that of the full model.
async function measure_tuning(page, name) {
  for (const [title, label] of Object.entries(sliders)) {
    const slider = page.getByRole('slider', {name: label, exact: true});
    const previews = [], fulls = [];
    for (let k = 0; k < 10; ++k) {
      const send = (type, steps) => slider.evaluate((input, [event, by]) => {
        input.value = Number(input.value) + by * Number(input.step);
        globalThis.measured_from = performance.now();
        input.dispatchEvent(new Event(event, {bubbles: true}));
      }, [type, steps]);
      previews.push(await until(page, /^Preview: [\d,]+ tets/, () => send('input', k % 2 ? -1 : 1)));
      fulls.push(await until(page, /^[\d,]+ tets/, () => send('change', 0)));
    }
    note_all(`${name}, ${title}: preview drawn after a slider's move`, previews);
    note_all(`${name}, ${title}: full model drawn after its release`, fulls);
  }
}

/// In the page: of each preview the moves of the slider that it shows, which are those before it was asked for, and when
/// it was drawn; they come in the order in which they were asked for.
function watch_drag(slider) {
  const line = document.querySelector('footer [role=status]'), {prototype} = Worker, {postMessage} = prototype;
  const moves = [], asked = [], seen = globalThis.drag = {latencies: [], drawn: []};
  slider.addEventListener('input', () => moves.push(performance.now()), true);
  prototype.postMessage = function(message, ...rest) {
    if (message.task === 'make_preview') asked.push(moves.splice(0));
    return postMessage.call(this, message, ...rest);
  };
  const watch = new MutationObserver(async () => {
    if (!line.textContent.startsWith('Preview')) return;
    const shown = asked.shift(), at = await globalThis.picture_begun();
    seen.drawn.push(at);
    seen.latencies.push(...shown.map(moved => at - moved));
  });
  watch.observe(line, {childList: true, characterData: true, subtree: true});
  seen.end = () => (watch.disconnect(), prototype.postMessage = postMessage);
}

/// Values that a slider is drawn between: usual ones, thresholds close to the surface, where more voxels count, and
/// lattices finer than usual.
const drags = [['P_in', 4, 9], ['P_in', 1, 1.7], ['cells', 33, 60]];

async function measure_drags(page, name) {
  for (const [title, low, high] of drags) {
    await measure_drag(page, `${name}, ${title} dragged between ${low} and ${high}`, sliders[title], low, high);
    await until(page, /^[\d,]+ tets/, () => page.getByRole('button', {name: 'Undo'}).click());
  }
}

/// The mouse draws a slider to and fro for two seconds, without pause.
async function measure_drag(page, name, label, low, high) {
  const slider = page.getByRole('slider', {name: label, exact: true});
  await slider.scrollIntoViewIfNeeded();
  const box = await slider.boundingBox(), thumb = 16;
  const at = await slider.evaluate(({min, max}, values) => values.map(value => (value - min) / (max - min)), [low, high]);
  const [left, right] = at.map(share => box.x + thumb / 2 + share * (box.width - thumb));
  await slider.evaluate(watch_drag);
  await page.mouse.move(left, box.y + box.height / 2);
  await page.mouse.down();
  const from = Date.now();
  for (let t = 0; t < 2000; t = Date.now() - from) {
    await page.mouse.move(left + (right - left) * (0.5 - 0.5 * Math.cos(t / 300)), box.y + box.height / 2);
    await page.waitForTimeout(8);
  }
  const {latencies, drawn} = await page.evaluate(() => (globalThis.drag.end(), globalThis.drag));
  const full = await until(page, /^[\d,]+ tets/, () => page.mouse.up());
  note_all(`${name}: from a move to the picture`, latencies);
  note_all(`${name}: from preview to preview`, drawn.slice(1).map((time, k) => time - drawn[k]));
  note(`${name}: full model after its release`, full);
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

/// Milliseconds a picture over two seconds of acting in each of the browser's frames.
const frame_time = (page, act) => page.evaluate(async source => {
  const step = new Function('k', source), before = globalThis.pictures, from = performance.now();
  for (let k = 0; performance.now() - from < 2000; ++k) {
    step(k);
    await new Promise(requestAnimationFrame);
  }
  return (performance.now() - from) / (globalThis.pictures - before);
}, act);

/// Frames a second of a live simulation that reach the page, decoded by its own reader. Its springs are soft and nothing
/// pulls at it, so that a step costs next to nothing.
async function measure_stream(page, seconds = 10) {
  const {vertices, rate, gap, dropped} = await page.evaluate(async seconds => {
    const headers = {Authorization: `Bearer ${document.querySelector('meta[name=isochor-token]').content}`, 'Content-Type': 'application/json'};
    const body = {type: 'deformable', edge_stiffness: 100, diagonal_stiffness: 100,
      lattice: {cells: [26, 26, 26], cell_size: 1 / 26, origin: [0, 1, 0]}};
    const made = await fetch('/api/v1/simulations?state=playing&wait_ms=10000', {method: 'POST', headers,
      body: JSON.stringify({duration: null, gravity: [0, 0, 0], bodies: [body]})});
    const {id, frames} = await made.json();
    const worker = new Worker('stream_worker.js', {type: 'module'});
    const seen = [], failed = new Promise((_, reject) => worker.addEventListener('error', ({message}) => reject(new Error(`the stream's worker: ${message}`))));
    worker.addEventListener('message', ({data: {line}}) => line?.type === 'frame' && seen.push([performance.now(), line]));
    worker.postMessage({task: 'follow', url: frames, headers, generation: 0});
    while (!seen.length) await Promise.race([failed, new Promise(resolve => setTimeout(resolve, 20))]);
    const first = seen.length, from = performance.now();
    await new Promise(resolve => setTimeout(resolve, 1000 * seconds));
    const counted = seen.slice(first).filter(([at]) => at <= from + 1000 * seconds);
    worker.terminate();
    await fetch(`/api/v1/simulations/${id}`, {method: 'DELETE', headers});
    const lines = counted.map(([, line]) => line);
    return {vertices: lines[0].bodies[0].positions.length / 3, rate: counted.length / seconds,
      gap: Math.max(...counted.slice(1).map(([at], k) => at - counted[k][0])),
      dropped: lines.at(-1).dropped - lines[0].dropped};
  }, seconds);
  note('stream: vertices of a frame', vertices, 'vertices');
  note('stream: frames that reach the page, decoded', rate, 'a second');
  note('stream: from frame to frame (worst)', gap);
  note(`stream: frames dropped in ${seconds} seconds`, dropped, 'frames');
}

async function measure_all(files) {
  await measure_opening();
  const page = await open_page({browser, server, prepare: made => made.addInitScript(watch_pictures)});
  await measure_stream(page);
  await measure_tuning(page, 'tree');
  await measure_drags(page, 'tree');
  for (const file of files) {
    const name = basename(file);
    await until(page, /^[\d,]+ tets/, () => page.locator('input[type=file]').setInputFiles(file));
    await measure_tuning(page, name);
    await measure_drags(page, name);
    await measure_large(page, name);
  }
}

try {
  const [first, ...more] = process.argv.slice(2);
  if (first === '--stream') await measure_stream(await open_page({browser, server}));
  else await measure_all(first ? [first, ...more] : []);
} finally {
  await browser.close();
  await server.stop();
}
