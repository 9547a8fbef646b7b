import test from 'node:test';
import assert from 'node:assert/strict';
import {execFile} from 'node:child_process';
import {mkdtemp, readFile, rm, writeFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {promisify} from 'node:util';
import {browser_tests, eventually, hold_at_preview, no_complaints, status} from './support/browser.js';

const suite = browser_tests();
const panel = (page, name) => page.getByRole('region', {name, exact: true});

/// A small cube, so that the grid is measured within seconds.
const small_cube = `#${Buffer.from(JSON.stringify({mesh: {sample: 'cube', name: 'cube'}, params: {voxels: 16, cells: 4}})).toString('base64url')}`;

/// Names of the points that nothing lies over: where a point stands is measured.
const uncovered = points => points.evaluateAll(all => all.filter(dot => {
  const {left, right, top, bottom} = dot.querySelector('.mark').getBoundingClientRect();
  return dot.contains(document.elementFromPoint((left + right) / 2, (top + bottom) / 2));
}).map(dot => dot.getAttribute('aria-label')));

test('error against run time: a clicked point gives its settings, and a budget proposes some', async () => {
  const page = await suite.open({hash: small_cube});
  const report = panel(page, 'Error against run time');
  await report.getByRole('button', {name: 'Measure error against run time'}).click();
  const points = report.locator('.error-plot .dot');
  await eventually(() => points.count(), n => n === 18, 'every setting of the grid is a point');
  await report.getByRole('button', {name: 'Cancel'}).waitFor({state: 'hidden'});
  const tolerance = page.getByLabel('Tolerance, exact value');
  assert.equal(await tolerance.inputValue(), '1e-6');
  const words = /^(\w+ · symplectic · 1e-0([24])), .* error \d\.\de-\d+, converged$/;
  await points.first().scrollIntoViewIfNeeded();
  const name = (await uncovered(points)).find(label => words.test(label));
  const [, series, digits] = words.exec(name);
  await report.getByRole('button', {name, exact: true}).locator('.mark').click();
  await status(page).filter({hasText: `Taken: ${series}`}).waitFor();
  assert.equal(await tolerance.inputValue(), digits === '2' ? '0.01' : '1e-4');
  await page.getByRole('button', {name: 'Undo'}).click();
  assert.equal(await tolerance.inputValue(), '1e-6');

  await report.getByLabel('Error shown').selectOption('trajectory_rms');
  await report.getByLabel('Fit my budget').fill('0.000001');
  await report.getByRole('button', {name: 'Fit', exact: true}).click();
  await report.getByText('No measured setting converges within 0.000001 ms.').waitFor();
  await report.getByLabel('Fit my budget').fill('1e6');
  await report.getByLabel('Fit my budget').press('Enter');
  await report.getByText(/^newton · \w+ · 1e-0[246], \d+ substeps: .* ms, with reserve .* ms, error /).waitFor();
  await report.getByRole('button', {name: 'Use these settings'}).click();
  await status(page).filter({hasText: 'Taken: newton · '}).waitFor();
  assert.equal(await report.locator('.dot.selected').count(), 1);
  assert.notEqual(await page.getByLabel('Substeps a frame', {exact: true}).inputValue(), 'auto');
  no_complaints(page);
  await page.context().close();
});

test('what is measured while a preview is shown is the whole model', async () => {
  const page = await suite.open({hash: small_cube});
  const release = await hold_at_preview(page, 'Cells', 5);
  const report = panel(page, 'Error against run time');
  const asked = page.waitForRequest(request => request.url().includes('/reports') && request.method() === 'POST');
  await report.getByRole('button', {name: 'Measure error against run time'}).click();
  await page.evaluate(() => new Promise(requestAnimationFrame));
  release();
  const {mesh} = (await asked).postDataJSON().scene.bodies.find(({type}) => type === 'deformable');
  const model = await page.evaluate(async id => (await fetch(`./api/v1/models/${id}`)).json(), mesh);
  assert.ok(model.stages.some(({name}) => name === 'embedding'), JSON.stringify(model.stages));
  await report.getByRole('button', {name: 'Cancel'}).click();
  await report.getByRole('button', {name: 'Cancel'}).waitFor({state: 'hidden'});
  no_complaints(page);
  await page.context().close();
});

test('the stability suite is seen as a map of stiffness over step', async () => {
  const page = await suite.open({hash: small_cube});
  const stability = panel(page, 'Stability');
  await stability.getByRole('button', {name: 'Run the stability suite'}).click();
  const [released, landing] = [stability.locator('.map').first(), stability.locator('.map').nth(1)];
  await eventually(() => released.locator('td').count(), n => n === 35, 'seven stiffnesses at five steps');
  assert.equal(await released.locator('td.bad').count(), 0);
  await eventually(() => landing.locator('td').count(), n => n > 0, 'a map of landings as well');
  assert.deepEqual(await released.locator('tbody th').allTextContents(), ['0', '1e2', '1e4', '1e6', '1e8', '1e10', '1e12']);
  await stability.getByRole('button', {name: 'Cancel'}).click();
  await stability.getByText(/of \d+ cases hold so far/).waitFor();
  no_complaints(page);
  await page.context().close();
});

const falling = {duration: 0.05, frame_rate: 60, gravity: [0, -9.81, 0], bodies: [{type: 'deformable', edge_stiffness: 100, diagonal_stiffness: 100,
  lattice: {cells: [1, 1, 1], cell_size: 1, origin: [0, 0, 0]}, angular_velocity: [0, 1, 2]}]};

/// The self-contained page of a real report, its document changed.
async function report_page(folder, change) {
  await writeFile(join(folder, 'scene.json'), JSON.stringify(falling));
  await promisify(execFile)(process.env.ISOCHOR_BINARY, ['report', join(folder, 'scene.json'), '-o', folder, '-q', '--repeats', '1', '--refinement', '2',
    '--solvers', 'newton', '--tolerances', '1e-2,1e-6', '--substeps', '1,2', '--resolutions', '1']);
  const html = await readFile(join(folder, 'report.html'), 'utf8'), [document] = /(?<=id="report">).*?(?=<)/s.exec(html);
  const report = JSON.parse(document);
  change(report);
  await writeFile(join(folder, 'report.html'), html.replace(document, () => JSON.stringify(report)));
  return `file://${folder}/report.html`;
}

test('the self-contained report says how the points ended, and plots the finite ones alone', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'isochor-'));
  const page = await suite.browser.newPage();
  const faults = [];
  page.on('pageerror', error => faults.push(error.stack));
  try {
    await page.goto(await report_page(folder, ({points}) => {
      Object.assign(points[0], {outcome: 'blew_up', reason: 'a point left the scene'});
      Object.assign(points[1], {outcome: 'infeasible', reason: 'the tolerance was not met'});
      for (const point of points) Object.assign(point.errors, {max_cell_volume: point === points[0] ? 1e9 : 1e-3 * (2 + points.indexOf(point)), max_penetration: point === points[0] ? 1 : 0});
    }));
    assert.equal(await page.locator('#outcomes').textContent(), '4 points: 2 converged, 1 infeasible, 1 blew up.');
    const figure = title => page.locator('figure').filter({has: page.getByText(title, {exact: true})});
    await figure('penetration (m)').getByText('Zero, or not defined, at every point that ended.').waitFor();
    const plot = figure('largest cell volume error').locator('.error-plot');
    const top = (await plot.locator('.blew_up .mark').boundingBox()).y;
    for (const mark of await plot.locator('.dot:not(.blew_up) .mark').all()) assert.ok((await mark.boundingBox()).y > top);
    assert.equal(await plot.locator('.dot.infeasible').count(), 1);
    await plot.locator('.blew_up .mark').click();
    assert.match(await page.locator('tr.picked').textContent(), /blew up.*a point left the scene/);
    assert.deepEqual(faults, []);
  } finally {
    await page.close();
    await rm(folder, {recursive: true});
  }
});
