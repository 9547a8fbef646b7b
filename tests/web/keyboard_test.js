import test from 'node:test';
import assert from 'node:assert/strict';
import {readFile} from 'node:fs/promises';
import {browser_tests, eventually, no_complaints, status} from './support/browser.js';
import {focused, missed, walk} from './support/keyboard.js';
import {at_rest, look, look_at_rest} from './support/pixels.js';

const suite = browser_tests();

/// Tab until the control of that name holds the focus.
async function go_to(page, name) {
  for (let k = 0; k < 200; ++k) {
    await page.keyboard.press('Tab');
    const stop = await focused(page);
    if (stop && (name instanceof RegExp ? name.test(stop.name) : stop.name === name)) return stop;
  }
  assert.fail(`no way by Tab to ${name}`);
}

/// What a key changes on each kind of control, and the key that takes it back.
const operations = {
  checkbox: {keys: [' ', ' '], read: stop => stop.checked},
  combobox: {keys: ['ArrowDown', 'ArrowUp'], otherwise: ['ArrowUp', 'ArrowDown'], read: stop => stop.value},
  slider: {keys: ['ArrowRight', 'ArrowLeft'], otherwise: ['ArrowLeft', 'ArrowRight'], read: stop => stop.value},
  spinbutton: {keys: ['ArrowUp', 'ArrowDown'], otherwise: ['ArrowDown', 'ArrowUp'], read: stop => stop.value},
  DisclosureTriangle: {keys: ['Enter', 'Enter'], read: stop => stop.open},
  toggle: {keys: ['Enter', 'Enter'], read: stop => stop.pressed},
};

async function operate(page, stop, {keys, otherwise = keys, read}) {
  await page.keyboard.press(keys[0]);
  let back = keys[1];
  if (read(await focused(page)) === read(stop)) {
    await page.keyboard.press(otherwise[0]);
    back = otherwise[1];
  }
  const after = await focused(page);
  assert.equal(after.name.replace(/ [\d.]+ m?s$| kept$| running$/, ''), stop.name.replace(/ [\d.]+ m?s$| kept$| running$/, ''), 'the focus stays');
  assert.notEqual(read(after), read(stop), `${stop.role} ${stop.name} answers to its keys`);
  await page.keyboard.press(back);
}

/// A small model, so that what keys change is there at once.
const small = {width: 1160, height: 520,
  hash: `#${Buffer.from(JSON.stringify({mesh: {sample: 'cube', name: 'cube'}, params: {voxels: 24, cells: 6}})).toString('base64url')}`};

test('Tab reaches every control that is seen; each has a name and shows its focus', async () => {
  const page = await suite.open();
  const voxels = page.waitForResponse('**/voxels*');
  for (const layer of ['2', '4']) await page.keyboard.press(layer);  // the controls of voxels and simulation as well
  await (await voxels).finished();
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  await at_rest(page);
  const stops = await walk(page, stop => {
    assert.ok(stop.name, `${stop.role} has a name`);
    assert.equal(stop.outline, 'solid', `${stop.name} shows its focus`);
  });
  assert.deepEqual(await missed(page), []);
  assert.ok(stops.length > 100, `${stops.length} stops`);
  no_complaints(page);
  await page.context().close();
});

test('at 390 px Tab goes down the page, and the view and the status never cover what it comes to', async () => {
  const page = await suite.open({width: 390, height: 844});
  await page.keyboard.press('4');
  await page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor();
  const regions = [];
  await walk(page, async stop => {
    const {region, seen} = await page.evaluate(() => {
      const element = document.activeElement, {x, y, width, height} = element.getBoundingClientRect();
      const top = document.elementFromPoint(x + width / 2, y + height / 2);
      return {region: [...document.body.children].find(part => part.contains(element)).getAttribute('aria-label'), seen: element.contains(top) || top?.contains(element)};
    });
    assert.ok(seen, `${stop.name} is seen`);
    if (regions.at(-1) !== region) regions.push(region);
  });
  assert.deepEqual(regions, ['Isochor', 'View', 'Transport', 'What is shown', 'Stages', 'Inspector']);
  assert.deepEqual(await missed(page), []);
  no_complaints(page);
  await page.context().close();
});

test('a menu that Tab leaves is closed', async () => {
  const page = await suite.open();
  await page.getByRole('button', {name: 'Presets'}).focus();
  await page.keyboard.press('Enter');
  const preset = page.getByRole('button', {name: /^Fine/});
  await preset.waitFor();
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('Tab');
  await preset.waitFor({state: 'hidden'});
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute('aria-label')), 'Shortcuts and help (?)');
  no_complaints(page);
  await page.context().close();
});

test('Space plays and pauses while a slider holds the focus', async () => {
  const page = await suite.open(small);
  await go_to(page, 'Cells');
  await page.keyboard.press(' ');
  await page.getByRole('button', {name: 'Pause (Space)'}).waitFor();
  await go_to(page, 'Frame');
  await page.keyboard.press(' ');
  await page.getByRole('button', {name: 'Play (Space)'}).waitFor();
  no_complaints(page);
  await page.context().close();
});

test('the keys of its kind operate every switch, choice, slider and number', async () => {
  const page = await suite.open(small);
  const tried = {};
  await walk(page, async stop => {
    const kind = stop.role === 'button' && stop.pressed !== null && !stop.part ? 'toggle' : stop.role;
    if (!operations[kind] || stop.name === 'Record (R)') return;
    await operate(page, stop, operations[kind]);
    tried[kind] = (tried[kind] ?? 0) + 1;
  });
  assert.ok(tried.spinbutton >= 15 && tried.slider >= 15 && tried.combobox >= 8 && tried.checkbox >= 4 && tried.toggle >= 7, JSON.stringify(tried));
  no_complaints(page);
  await page.context().close();
});

/// What Enter on each button that acts at once brings about: a text of the status line, or what is seen.
const says = pattern => page => status(page).filter({hasText: pattern}).waitFor();
const dialog = name => async page => {
  await page.getByRole('dialog', {name}).waitFor();
  await page.keyboard.press('Escape');
};
const saves = pattern => async (page, act) => {
  const [file] = await Promise.all([page.waitForEvent('download'), act()]);
  assert.match(file.suggestedFilename(), pattern);
};
const moves = async (page, act) => {
  const before = await look_at_rest(page);
  await act();
  await eventually(() => look(page), seen => seen.sum !== before.sum, 'the view changes');
};
const lists = (name, state = 'visible') => page => page.locator('.collider', {hasText: name}).waitFor({state});
const menu = async (page, act) => {
  const opener = await focused(page);
  await act();
  const first = await eventually(() => focused(page), stop => stop.name !== opener.name, 'the menu takes the focus');
  await page.keyboard.press('ArrowDown');
  assert.notEqual((await focused(page)).name, first.name, 'arrows walk the menu');
  await page.keyboard.press('Escape');
};
const buttons = {
  'Open': async (page, act) => void await Promise.all([page.waitForEvent('filechooser'), act()]),
  'Samples': menu, 'Presets': menu,
  'Export': dialog('Export'),
  'Share': says(/^(Link copied|The link stands)/),
  'Shortcuts and help (?)': dialog('Shortcuts and help'),
  'Light or dark': async (page, act) => {
    await act();
    await page.locator('html[data-theme=light]').waitFor();
    await page.keyboard.press('Enter');
  },
  'Right': moves, 'Top': moves, 'Front': moves,
  'Fit (F)': async (page, act) => {
    await moves(page, () => page.evaluate(() => document.querySelector('canvas.view').dispatchEvent(new WheelEvent('wheel', {deltaY: -600}))));
    await moves(page, act);
  },
  'Save a picture of the view': saves(/\.png$/),
  'Set thresholds as probabilities': page => page.locator('[data-path="params.p_in"]').waitFor(),
  'Reset Cells': page => page.getByRole('button', {name: 'Reset Cells'}).waitFor({state: 'hidden'}),
  'Step (.)': page => page.locator('.transport .time').filter({hasText: 'step 1 '}).waitFor(),
  'Step back (,)': page => page.locator('.transport .time').filter({hasText: 'step 0 '}).waitFor(),
  'Play (Space)': page => page.getByRole('button', {name: 'Pause (Space)'}).waitFor(),
  'Pause (Space)': page => page.getByRole('button', {name: 'Play (Space)'}).waitFor(),
  'Record (R)': async (page, act) => {
    await act();
    await page.locator('button.recording').waitFor();
    await saves(/\.ndjson$/)(page, () => page.keyboard.press('Enter'));
  },
  'Add a sphere': lists('sphere 1'), 'Add a box': lists('box 1'), 'Add a plane': lists('plane 1'),
  'Undo': page => page.locator('.collider', {hasText: 'plane 1'}).waitFor({state: 'detached'}), 'Redo': lists('plane 1'),
  'Restart (Home)': page => page.locator('.transport .time').filter({hasText: /^0\.00 s/}).waitFor(),
};

test('Enter works every button that acts at once', async () => {
  const page = await suite.open(small);
  page.on('filechooser', () => {});  // from now on, or the first would be too early
  for (const [name, effect] of Object.entries(buttons)) {
    await go_to(page, name);
    const act = () => page.keyboard.press('Enter');
    if (effect.length < 2) await act();
    await effect(page, act);
  }
  no_complaints(page);
  await page.context().close();
});

test('bins of the histogram are walked by arrows, chosen by Enter and extended with Shift', async () => {
  const page = await suite.open();
  await page.keyboard.press('1');
  const all = await look_at_rest(page);
  await go_to(page, / tets$/);
  for (let k = 0; k < 14; ++k) await page.keyboard.press('ArrowRight');
  const bin = await focused(page);
  assert.match(bin.name, /^41\.1 – 44\.1°: [\d,]+ tets$/);
  await page.keyboard.press('Enter');
  const one = await eventually(() => look(page), seen => seen.tets < 0.9 * all.tets, 'the cells of one bin');
  assert.equal((await focused(page)).name, bin.name, 'the bin keeps the focus');
  await page.keyboard.press('Shift+ArrowRight');
  await eventually(() => look(page), seen => seen.sum !== one.sum, 'the cells of two bins');
  assert.equal(await page.locator('.bin[aria-pressed=true]').count(), 2);
  await go_to(page, 'Show all');
  await page.keyboard.press('Enter');
  await eventually(() => look(page), seen => seen.tets > 0.95 * all.tets, 'all cells');
  no_complaints(page);
  await page.context().close();
});

test('the body is pulled and a collider moved, resized and removed by keys', async () => {
  const page = await suite.open({width: 1160, height: 640});
  await page.getByLabel('Scene', {exact: true}).selectOption('sphere');
  const sent = [];
  page.on('request', request => /grabs|colliders/.test(request.url()) && sent.push([request.method(), new URL(request.url()).pathname.split('/').at(-2), request.postDataJSON()]));
  await go_to(page, /^3D view/);
  await page.keyboard.press('f');
  await page.keyboard.press('g');
  await says(/^Grabbed /)(page);
  const held = await status(page).textContent();
  for (const name of ['ArrowRight', 'ArrowUp', 'PageUp']) await page.keyboard.press(name);
  await page.keyboard.press('Escape');
  await says('Let go')(page);
  await eventually(() => Promise.resolve(sent), all => all.some(([, kind, json]) => json && (kind === 'grabs' ? json.target : json.position)), `${held} moves`);

  await go_to(page, 'ball');
  if (!(await focused(page)).open) await page.keyboard.press('Enter');
  sent.length = 0;
  const slider = await go_to(page, 'X');
  await page.keyboard.press('ArrowRight');
  await eventually(() => Promise.resolve(sent), all => all.some(([, kind]) => kind === 'colliders'), 'the collider moves');
  assert.ok(Number((await focused(page)).value) > Number(slider.value));
  const radius = await go_to(page, 'Radius');
  await page.keyboard.press('ArrowRight');
  assert.ok(Number((await focused(page)).value) > Number(radius.value));
  await go_to(page, 'Remove ball');
  await page.keyboard.press('Enter');
  await lists('ball', 'detached')(page);
  no_complaints(page);
  await page.context().close();
});

test('a point of the report is reached by arrows and taken by Enter, and keeps the focus', async () => {
  const page = await suite.open(small);
  await go_to(page, 'Measure error against run time');
  await page.keyboard.press('Enter');
  await eventually(() => page.locator('.error-plot .dot').count(), n => n === 18, 'every point');
  await page.locator('.report').getByRole('button', {name: 'Cancel'}).waitFor({state: 'hidden'});
  await go_to(page, / ms \(.+\), error /);
  await page.keyboard.press('End');
  const point = await focused(page);
  await page.keyboard.press('Enter');
  await says(/^Taken: /)(page);
  assert.equal((await focused(page)).name, point.name);
  await go_to(page, 'Orders of convergence');
  await page.keyboard.press('Enter');
  assert.equal((await focused(page)).open, true);
  await go_to(page, 'Fit my budget');
  await page.keyboard.press('Control+a');
  await page.keyboard.type('1000');
  await page.keyboard.press('Enter');
  await go_to(page, 'Use these settings');
  await page.keyboard.press('Enter');
  await says(/^Taken: /)(page);
  no_complaints(page);
  await page.context().close();
});

test('a defect is flown to, what stands there picked and P along its ray drawn, and a free clip turned, by keys', async () => {
  const page = await suite.open({width: 1366, height: 768});
  const before = await look_at_rest(page);
  await go_to(page, /open edges: fly to the next$/);
  await page.keyboard.press('Enter');
  await says(/^open edges: 1 of /)(page);
  await eventually(() => look(page), seen => seen.sum !== before.sum, 'the view flies');
  await page.keyboard.press('p');
  await says(/^(Cell|Voxel|Triangle) /)(page);
  await page.locator('.ray-plot').getByRole('img', {name: /^P along the ray through \d+ voxels/}).waitFor();
  await page.keyboard.press('Escape');
  await says('Nothing picked')(page);
  await page.keyboard.press('f');
  await go_to(page, 'Clip axis');
  await page.keyboard.press('End');
  await page.getByRole('button', {name: /^Face me/}).waitFor();
  const along = await look_at_rest(page);
  await go_to(page, /^3D view/);
  for (let k = 0; k < 6; ++k) await page.keyboard.press('ArrowLeft');
  await go_to(page, /^Face me/);
  await page.keyboard.press('Enter');
  await eventually(() => look(page), seen => seen.sum !== along.sum, 'the plane turns');
  no_complaints(page);
  await page.context().close();
});

test('the export dialog keeps Tab, saves by Enter, and gives the focus back', async () => {
  const page = await suite.open(small);
  await go_to(page, 'Export');
  await page.keyboard.press('Enter');
  await page.getByRole('dialog', {name: 'Export'}).waitFor();
  await go_to(page, /^Save for .*SOFA/);
  await saves(/\.msh$/)(page, () => page.keyboard.press('Enter'));
  await go_to(page, 'Save the parameters');
  await saves(/\.json$/)(page, () => page.keyboard.press('Enter'));
  for (let k = 0; k < 30; ++k) {
    await page.keyboard.press('Tab');
    assert.ok(await page.evaluate(() => document.activeElement === document.body || document.activeElement.closest('dialog') !== null), 'Tab stays in the dialog');
  }
  await page.keyboard.press('Escape');
  assert.equal((await focused(page)).name, 'Export');
  no_complaints(page);
  await page.context().close();
});

test('a recording is made, opened, scrubbed and closed by keys', async () => {
  const page = await suite.open(small);
  page.on('filechooser', () => {});  // from now on, or the first would be too early
  await go_to(page, 'Record (R)');
  await page.keyboard.press('Enter');
  await page.locator('button.recording').waitFor();
  for (let k = 1; k <= 3; ++k) {
    await page.keyboard.press('.');
    await page.locator('.transport .time').filter({hasText: `step ${k} `}).waitFor();
  }
  const [file] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('r')]);
  const recording = {name: file.suggestedFilename(), mimeType: '', buffer: await readFile(await file.path())};
  await go_to(page, 'Open');
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.keyboard.press('Enter')]);
  await chooser.setFiles(recording);
  await page.getByRole('button', {name: 'Close the recording'}).waitFor();
  const time = page.locator('.transport .time');
  const frame = await go_to(page, 'Frame');
  await page.keyboard.press('End');
  await time.filter({hasText: 'step 3 '}).waitFor();
  await page.keyboard.press('ArrowLeft');
  await time.filter({hasText: 'step 2 '}).waitFor();
  assert.equal((await focused(page)).name, frame.name);
  await go_to(page, 'Close the recording');
  await page.keyboard.press('Enter');
  await page.getByRole('button', {name: 'Record (R)'}).waitFor();
  no_complaints(page);
  await page.context().close();
});
