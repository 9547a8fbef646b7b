import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, drop, eventually, fact, newest_run, no_complaints, status} from './support/browser.js';
import {at_rest, look, look_at_rest} from './support/pixels.js';

const suite = browser_tests();

const small = {width: 1160, height: 640};
const time = async page => Number.parseFloat(await page.locator('.transport .time').textContent());
const play = page => page.getByRole('button', {name: 'Play (Space)'}).click();
const pause = page => page.getByRole('button', {name: 'Pause (Space)'}).click();
/// Until the run has paused, and the last frame that was on its way is shown.
const paused = async page => {
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  const {seq} = await eventually(() => newest_run(page), ({state}) => state === 'paused', 'it has paused');
  await page.locator('.transport .time').filter({hasText: `step ${seq} `}).waitFor();
};
/// Scenes are compiled only once the function that it returns is called.
const hold_compiling = async page => {
  let go_on;
  const held = new Promise(resolve => go_on = resolve);
  await page.route('**/api/v1/simulations?*', async route => {
    await held;
    await route.continue();
  });
  return go_on;
};
const played_to = (page, seconds) => eventually(() => time(page), t => t >= seconds, `played to ${seconds} s`);

test('play, pause, step, restart and scrub', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.3);
  await pause(page);
  await paused(page);
  const stopped = await time(page);
  const scrub = page.getByRole('slider', {name: 'Frame'});
  const last = Number(await scrub.getAttribute('max'));
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await eventually(async () => Number(await scrub.getAttribute('max')), n => n === last + 1, 'one frame more');
  await scrub.fill('3');
  await eventually(() => time(page), t => t < stopped, 'an earlier frame');
  await page.getByRole('button', {name: 'Restart (Home)'}).click();
  await eventually(() => time(page), t => t === 0, 'the beginning');
  no_complaints(page);
  await page.context().close();
});

test('a run that has paused says so, though the answer to the request comes late', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.1);
  let go_on;
  const told = new Promise(resolve => go_on = resolve);
  await page.route('**/simulations/*', async route => {
    const response = await route.fetch();
    await told;
    await page.waitForTimeout(1000);  // longer than a pause goes unnoticed
    await route.fulfill({response});
  });
  const answered = page.waitForResponse(response => response.request().method() === 'PATCH');
  await pause(page);
  await paused(page);
  go_on();
  await (await answered).finished();
  await paused(page);
  assert.equal(await status(page).textContent(), 'Paused');
  no_complaints(page);
  await page.context().close();
});

test('scrubbed while it plays, a run pauses and shows what was asked for, whatever frames still come', async () => {
  const page = await suite.open(small);
  const scrub = page.getByRole('slider', {name: 'Frame'});
  for (let turn = 0; turn < 4; ++turn) {  // a frame may come just before the slider moves, or just after
    await play(page);
    await played_to(page, 0.1);
    await scrub.fill('0');
    const {seq} = await eventually(() => newest_run(page), ({state}) => state === 'paused', 'it has paused');
    await eventually(async () => Number(await scrub.getAttribute('max')), n => n === seq, 'the last frame has come');
    assert.equal(await time(page), 0);
    await page.getByRole('button', {name: 'Restart (Home)'}).click();
    await eventually(async () => Number(await scrub.getAttribute('max')), n => n === 0, 'the beginning');
  }
  no_complaints(page);
  await page.context().close();
});

test('while a scene is compiled to be played, Play stands as pressed, the model stays in view, and it can be taken back', async () => {
  const page = await suite.open(small);
  const go_on = await hold_compiling(page);
  await play(page);
  await page.locator('.transport .time').filter({hasText: 'compiling…'}).waitFor();
  assert.equal(await page.locator('.play').getAttribute('aria-label'), 'Pause (Space)');
  assert.ok((await look(page)).tets > 2000, 'the tets are still there');
  await pause(page);
  go_on();
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  await play(page);
  await played_to(page, 0.05);
  no_complaints(page);
  await page.context().close();
});

test('the layer of the simulation turned on and off again while it is compiled leaves the view as it was', async () => {
  const page = await suite.open(small);
  const go_on = await hold_compiling(page);
  const tets = page.getByRole('button', {name: 'Tets', exact: true});
  await page.getByRole('button', {name: 'Sim', exact: true}).click();
  await page.locator('.transport .time').filter({hasText: 'compiling…'}).waitFor();
  await page.getByRole('button', {name: 'Sim', exact: true}).click();
  go_on();
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  assert.equal(await tets.getAttribute('aria-pressed'), 'true');
  await eventually(() => look(page), s => s.tets > 2000, 'the tets are still there');
  no_complaints(page);
  await page.context().close();
});

test('the inspector plots the run and lists the plan with its reasons', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.2);
  for (const title of ['Volume error', 'Energy, J', 'Step, ms', 'Substeps']) await page.getByRole('figure', {name: title}).waitFor();
  assert.ok(await fact(page, 'Largest cell error') <= 1e-6);
  for (const title of ['Compiled in', 'Left out']) await page.locator('.plan h3', {hasText: title}).waitFor();
  assert.ok(await page.locator('.plan li').count() > 3);
  await page.context().close();
});

test('plots of a run that has only its start count from it, and not to a hundred seconds', async () => {
  const page = await suite.open(small);
  await page.evaluate(() => {
    const {prototype} = CanvasRenderingContext2D, {fillText} = prototype;
    globalThis.labels = new Set();
    prototype.fillText = function(text, ...rest) {
      globalThis.labels.add(text);
      return fillText.call(this, text, ...rest);
    };
  });
  await page.getByRole('button', {name: 'Sim', exact: true}).click();
  const labels = await eventually(() => page.evaluate(() => [...globalThis.labels]), seen => seen.includes('0.05'), 'an axis of a tenth of a second');
  assert.ok(!labels.includes('25'), labels.join(', '));
  no_complaints(page);
  await page.context().close();
});

/// Stretched, and held so: no step can give it its volume back.
const held = JSON.stringify({name: 'held', duration: 2, frame_rate: 60, gravity: [0, 0, 0],
  bodies: [{name: 'cube', type: 'deformable', edge_stiffness: 100, diagonal_stiffness: 100,
    lattice: {cells: [2, 2, 2], cell_size: 0.5, origin: [0, 0, 0]}, start: {affine: [[1.2, 0, 0], [0, 1, 0], [0, 0, 1]]}}],
  pins: [{body: 'cube', inside: {min: [-9, -9, -9], max: [9, 9, 9]}, to: null}]});

test('a tolerance that a step does not meet is said', async () => {
  const page = await suite.open(small);
  const promise = page.locator('.inspector dt', {hasText: /^Volume and depth$/}).locator('xpath=following-sibling::dd[1]');
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  await promise.filter({hasText: /^held$/}).waitFor();
  await drop(page, 'held.json', held);
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  await promise.filter({hasText: /^not held$/}).waitFor();
  no_complaints(page);
  await page.context().close();
});

test('material, gravity and tolerance change while it runs, without a restart', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.1);
  const changed = [];
  page.on('request', request => request.method() === 'PATCH' && changed.push(request.postDataJSON()));
  const field = async (name, value) => {
    await page.getByLabel(`${name}, exact value`, {exact: true}).fill(value);
    await page.getByLabel(`${name}, exact value`, {exact: true}).press('Enter');
  };
  const at = await time(page);
  await field('Gravity', '-3');
  await field('Edge stiffness', '500');
  await field('Tolerance', '0.0001');
  await eventually(() => Promise.resolve(changed.length), n => n === 3, 'three changes sent');
  assert.equal(changed[0].gravity[1], -3);
  assert.equal(changed[1].materials[0].edge_stiffness, 500);
  assert.equal(changed[2].solver.tolerance, 1e-4);
  await played_to(page, at + 0.1);
  no_complaints(page);
  await page.context().close();
});

test('damping changes while it runs, and takes the energy out', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.1);
  const now = async () => {
    const {t, metrics} = await newest_run(page);
    return {t, energy: metrics.kinetic_energy + metrics.potential_energy};
  };
  const before = await now();
  await page.getByLabel('Damping, exact value').fill('0.05');
  await page.getByLabel('Damping, exact value').press('Enter');
  const after = await eventually(now, ({energy}) => energy < 0.5 * before.energy, 'half the energy is gone');
  assert.ok(after.t > before.t, 'without a restart');
  no_complaints(page);
  await page.context().close();
});

test('the fields of a scene that says little show what it runs with, and moduli and damping change while it runs', async () => {
  const page = await suite.open(small);
  const refused = [];
  page.on('response', response => response.status() >= 400 && refused.push(response.url()));
  await drop(page, 'little.json', JSON.stringify({name: 'little', duration: null,
    bodies: [{name: 'block', type: 'deformable', edge_modulus: 30000, lattice: {cells: [4, 4, 4], cell_size: 0.1, origin: [-0.2, 1, -0.2]}}]}));
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  const exact = name => page.getByLabel(`${name}, exact value`, {exact: true});
  const shown = await Promise.all(['Mass density', 'Friction', 'Gravity', 'Tolerance', 'Diagonal stiffness'].map(name => exact(name).inputValue()));
  assert.deepEqual(shown.map(Number), [1000, 0.3, -9.81, 1e-6, 1000]);
  await play(page);
  await played_to(page, 0.1);
  for (const [name, value] of [['Damping', '0.01'], ['Edge modulus', '50000']]) {
    const changed = page.waitForResponse(response => response.request().method() === 'PATCH');
    await exact(name).fill(value);
    await exact(name).press('Enter');
    assert.equal((await changed).status(), 200, name);
  }
  assert.deepEqual(refused, []);
  assert.ok((await newest_run(page)).t > 0.1, 'without a restart');
  no_complaints(page);
  await page.context().close();
});

test('a step takes back a play that still waits for its run', async () => {
  const page = await suite.open(small);
  const go_on = await hold_compiling(page);
  await page.keyboard.press(' ');
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  await page.keyboard.press('.');
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  go_on();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  assert.equal((await newest_run(page)).state, 'paused');
  no_complaints(page);
  await page.context().close();
});

test('a run that begins anew lets go of what was grabbed in the last one', async () => {
  const page = await suite.open(small);
  await page.keyboard.press('g');
  await status(page).filter({hasText: /^Grabbed /}).waitFor();
  await page.getByLabel('Up axis of the file', {exact: true}).selectOption('z');
  await status(page).filter({hasText: 'started again'}).waitFor();
  const sent = [];
  page.on('request', request => request.url().includes('/grabs/') && sent.push(request.method()));
  await page.locator('canvas.view').focus();
  await page.keyboard.press('ArrowRight');
  await played_to(page, await time(page) + 0.05);
  assert.deepEqual(sent, []);
  no_complaints(page);
  await page.context().close();
});

/// A mirrored block: all its tets are inverted at the start.
const mirrored = JSON.stringify({name: 'mirrored', duration: null, frame_rate: 60, gravity: [0, 0, 0],
  solver: {volume: 'newton', constraint: 'per_cell', tolerance: 1e-6, springs: 'auto', substeps: 'auto', max_iterations: 40},
  bodies: [{name: 'block', type: 'deformable', lattice: {cells: [4, 4, 4], cell_size: 0.2, origin: [-0.4, 0, -0.4]}, density: 300,
    edge_stiffness: 1000, diagonal_stiffness: 300, start: {invert: true}}], pins: [], joints: []});

test('the cells of a sample scene are coloured by their volume error, and its name stands as the scene', async () => {
  const page = await suite.open(small);
  await page.getByRole('button', {name: 'Samples'}).click();
  await page.getByRole('button', {name: 'Sphere meets a weak cube'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  const scene = page.getByLabel('Scene', {exact: true});
  assert.match(await scene.locator('option:checked').textContent(), /^Sphere meets cube/);
  await page.getByLabel('Show the simulation as').selectOption('cells');
  await page.getByLabel('Colour tets by').selectOption('volume_error');
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await eventually(() => look(page), seen => seen.sand < 500 && seen.all - seen.sand > 3000, 'no cell without a colour');
  await page.locator('.color-panel h3', {hasText: 'Volume error'}).waitFor();
  await scene.selectOption('sway');
  await eventually(() => page.getByLabel('Edge stiffness, exact value').inputValue(), value => value === '150', 'back to a scene of the model');
  no_complaints(page);
  await page.context().close();
});

test('sample scenes with meshes, joints and lattices open and take a step, one after the other', async () => {
  const page = await suite.open(small);
  for (const title of ['Tree and ball', 'Chain', 'Dumbbell', 'Cube on torus']) {
    await page.getByRole('button', {name: 'Samples'}).click();
    await page.getByRole('group', {name: 'Samples'}).getByRole('button', {name: title, exact: true}).click();
    await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
    await page.getByRole('button', {name: 'Step (.)'}).click();
    await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  }
  const torus = await page.evaluate(async () => {
    const {simulations} = await (await fetch('./api/v1/simulations')).json();
    const {topology} = simulations.find(({name}) => name.includes('torus'));
    const {bodies} = await (await fetch(topology)).json();
    return bodies.find(({name}) => name === 'torus');
  });
  assert.deepEqual(torus.surface.shape, [2304, 3], 'the mesh of a rigid body is there to be seen');
  no_complaints(page);
  await page.context().close();
});

test('inverted tets are counted and glow crimson until they are cured', async () => {
  const page = await suite.open(small);
  await drop(page, 'mirrored.json', mirrored);
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  await page.getByRole('button', {name: 'Fit (F)'}).click();
  await eventually(() => look(page), seen => seen.crimson > 2000, 'all of it glows');
  await eventually(() => fact(page, 'Inverted tets'), n => n === 320, 'all of them are counted');
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  await eventually(() => look(page), seen => seen.crimson < 20, 'nothing glows');
  await eventually(() => fact(page, 'Inverted tets'), n => n === 0, 'none is counted');
  no_complaints(page);
  await page.context().close();
});

test('a collider added before anything was played is seen, and one step back shows the model again', async () => {
  const page = await suite.open(small);
  await page.getByRole('button', {name: 'Add a sphere'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  const sim = page.getByRole('button', {name: 'Sim', exact: true}), pressed = value => eventually(() => sim.getAttribute('aria-pressed'), now => now === value, 'the layer');
  await pressed('true');
  await page.getByRole('button', {name: 'Undo'}).click();
  await pressed('false');
  await eventually(() => look(page), seen => seen.tets > 2000, 'the tets');
  no_complaints(page);
  await page.context().close();
});

test('colliders are added, moved, resized and removed while it runs, which goes on', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.05);
  const scrub = page.getByRole('slider', {name: 'Frame'});
  /// After the act the frames begin where the run was, and go on.
  const goes_on = async act => {
    const seq = Number(await scrub.inputValue());
    await act();
    await eventually(async () => Number(await scrub.getAttribute('min')), first => first >= seq, 'frames from where the run was');
    await eventually(async () => Number(await scrub.getAttribute('max')), last => last > seq + 5, 'the run goes on');
  };
  for (const kind of ['sphere', 'box', 'plane']) await goes_on(() => page.getByRole('button', {name: `Add a ${kind}`}).click());
  const sphere = page.locator('.collider', {hasText: 'sphere 1'});
  const moves = [];
  page.on('request', request => request.url().includes('/colliders/') && moves.push(request.postDataJSON()));
  await sphere.getByLabel('X, exact value', {exact: true}).fill('0.7');
  await sphere.getByLabel('X, exact value', {exact: true}).press('Enter');
  await eventually(() => Promise.resolve(moves.length), n => n === 1, 'the move is sent');
  assert.equal(moves[0].position[0], 0.7);
  await goes_on(async () => {
    await sphere.getByLabel('Radius, exact value', {exact: true}).fill('0.3');
    await sphere.getByLabel('Radius, exact value', {exact: true}).press('Enter');
  });
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  await goes_on(() => page.getByRole('button', {name: 'Remove box 1'}).click());
  assert.equal(await page.locator('.collider', {hasText: 'box 1'}).count(), 0);
  no_complaints(page);
  await page.context().close();
});

/// Moves the mouse down the middle of the view, or up it, until the cursor says that it is over a body.
async function body_under_mouse(page, {upwards = false} = {}) {
  const view = page.locator('canvas.view');
  const box = await view.boundingBox();
  const x = box.x + box.width / 2;
  for (let k = 0.3; k < 0.85; k += 0.02) {
    const y = box.y + box.height * (upwards ? 1.15 - k : k);
    await page.mouse.move(x, y);
    if (await view.evaluate(canvas => canvas.style.cursor) === 'grab') return {x, y};
  }
  return assert.fail('no body under the mouse');
}

test('the body is dragged by the mouse and by keys', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.05);
  const grabs = [];
  page.on('request', request => request.url().includes('/grabs/') && grabs.push(request.method()));
  await pause(page);
  await paused(page);
  const held = await body_under_mouse(page);
  const before_drag = await look_at_rest(page);
  await page.mouse.down();
  await page.mouse.move(held.x + 120, held.y - 30, {steps: 6});
  await eventually(() => Promise.resolve(grabs), all => all.includes('PUT'), 'grabbed');
  await eventually(() => look(page), s => s.sum !== before_drag.sum, 'the body follows');
  await page.mouse.up();
  await eventually(() => Promise.resolve(grabs), all => all.includes('PUT') && all.at(-1) === 'DELETE', 'grabbed and released');
  grabs.length = 0;
  await page.locator('canvas.view').focus();
  await page.keyboard.press('g');
  await status(page).filter({hasText: /^Grabbed/}).waitFor();
  await page.keyboard.press('ArrowRight');
  await eventually(() => Promise.resolve(grabs), all => all.includes('PUT'), 'pulled by keys');  // let go before, it would not be
  await page.keyboard.press('Escape');
  await eventually(() => Promise.resolve(grabs), all => all.at(-1) === 'DELETE', 'and released');
  no_complaints(page);
  await page.context().close();
});

test('a collider is dragged by the mouse, in one step of the history', async () => {
  const page = await suite.open(small);
  await page.getByLabel('Scene', {exact: true}).selectOption('sphere');
  await page.getByRole('button', {name: 'Step (.)'}).click();
  await page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor();
  const moved = page.waitForRequest(request => request.url().includes('/colliders/') && request.method() === 'PUT');
  const x = page.locator('.collider', {hasText: 'ball'}).getByLabel('X, exact value', {exact: true});
  const before_drag = await x.inputValue();
  await at_rest(page);
  const held = await body_under_mouse(page, {upwards: true});
  await page.mouse.down();
  await page.mouse.move(held.x + 90, held.y, {steps: 5});
  await page.mouse.up();
  await moved;
  await eventually(() => x.inputValue(), value => value !== before_drag, 'the field shows where it is');
  await page.getByRole('button', {name: 'Undo'}).click();
  await eventually(() => x.inputValue(), value => value === before_drag, 'back in one step');
  no_complaints(page);
  await page.context().close();
});

test('a recording is saved, and dropped on the page it plays again', async () => {
  const page = await suite.open(small);
  await play(page);
  await played_to(page, 0.05);
  let let_pass;
  const ended = new Promise(resolve => let_pass = resolve);
  await page.route('**/frames?pace=every*', route => ended.then(() => route.continue()));  // late, as on a slow line
  await page.getByRole('button', {name: 'Record (R)'}).click();
  const begun = await time(page);
  await played_to(page, begun + 0.25);
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name: 'Record (R)'}).click().then(let_pass)]);
  const text = await readFile(await file.path(), 'utf8');
  const lines = text.trimEnd().split('\n').map(line => JSON.parse(line));
  assert.equal(lines[0].type, 'hello');
  assert.ok(lines[0].bodies[0].tets);
  assert.deepEqual(lines[0].bodies[0].embedded.triangles.shape, [6064, 3], 'with the skin');
  const frames = lines.filter(line => line.type === 'frame');
  assert.ok(frames[0].t < begun + 0.01 && frames.at(-1).t > begun + 0.24, 'from what was shown to what was shown');
  frames.forEach((frame, k) => assert.equal(frame.seq, frames[0].seq + k, 'every frame is there'));
  await page.context().close();

  const other = await suite.open(small);
  await drop(other, 'run.ndjson', text);
  await status(other).filter({hasText: 'Recording loaded'}).waitFor();
  const scrub = other.getByRole('slider', {name: 'Frame'});
  await eventually(async () => Number(await scrub.getAttribute('max')), n => n === frames.at(-1).seq, 'all frames');
  await eventually(() => look(other), s => s.sand + s.tets > 3000, 'the body is seen');
  await play(other);
  await eventually(() => time(other), t => t >= frames.at(-1).t - 0.02, 'played to its end');
  await other.locator('canvas.view').press('g');
  await status(other).filter({hasText: 'A recording cannot be dragged'}).waitFor();
  await other.getByRole('button', {name: 'Close the recording'}).click();
  await other.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  assert.ok(await other.getByRole('button', {name: 'Record (R)'}).isVisible(), 'the scene again');
  no_complaints(other);
  await other.context().close();
});
