// Draws the report that stands in this document.
import {h} from '../ui/dom.js';
import {error_legend, error_plot, floor_of, in_words, order_text, orders_list, single_out, usable} from './error_plot.js';
import {stability_maps} from './stability_map.js';

const report = JSON.parse(document.getElementById('report').textContent);
const content = document.getElementById('content');
const say = (id, text) => document.getElementById(id).textContent = text;

function digits(value) {
  if (value === null || value === undefined) return '–';
  if (Number.isInteger(value)) return String(value);
  const plain = Math.abs(value) >= 1e-2 && Math.abs(value) < 1e5;
  return plain ? String(Number(value.toPrecision(3))) : value.toExponential(1);
}

/// Columns that say nothing are left out.
function table(title, all_names, all_rows, row_class = () => '') {
  const said = all_names.map((_, column) => all_rows.some(row => row[column] !== ''));
  const [head, ...rows] = [all_names, ...all_rows].map(row => row.filter((_, column) => said[column]));
  const text = value => ({class: typeof value === 'string' ? 'text' : ''});
  const cell = value => h('td', text(value), typeof value === 'string' ? value : digits(value));
  const lines = rows.map((row, k) => h('tr', {class: row_class(k)}, row.map(cell)));
  const body = h('tbody', {}, lines);
  const headers = head.map((name, column) => h('th', {scope: 'col', ...text(rows[0]?.[column])},
    h('button', {type: 'button', title: 'Sort by it', onclick: () => sort(column)}, name)));
  const sort = column => {
    const falling = headers[column].ariaSort === 'ascending';
    for (const header of headers) header.removeAttribute('aria-sort');
    headers[column].setAttribute('aria-sort', falling ? 'descending' : 'ascending');
    const order = rows.map((row, k) => [row[column], lines[k]]).sort(([a], [b]) => (falling ? -1 : 1) * in_order(a, b));
    body.append(...order.map(([, line]) => line));
  };
  content.append(h('h2', {}, title), scrolled(title, h('table', {}, h('thead', {}, h('tr', {}, headers)), body)));
  return lines;
}

const in_order = (a, b) => typeof a === 'string' ? a.localeCompare(b, 'en', {numeric: true}) : (a ?? Infinity) - (b ?? Infinity);

const scrolled = (title, element) => h('div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': title}, element);

/// Why an error has no plot, in words; null where it has one.
function nothing_to_plot(name) {
  const points = report.points.filter(usable);
  const most = Math.max(0, ...points.map(point => point.errors[name] ?? 0)), floor = floor_of(report, name);
  const where = points.length < report.points.length ? 'at every point that ended' : 'at every point';
  if (points.length === 0) return 'Every point blew up, was stopped or failed.';
  if (most === 0) return `Zero, or not defined, ${where}.`;
  if (most <= floor) return `At most ${digits(most)} ${where}: no more than ${floor < 1e-13 ? 'round-off' : `the reference's own error of ${digits(floor)}`}.`;
  return null;
}

/// One plot an error. `pick` gets the index of a point that was chosen.
function draw_plots(time, pick) {
  const plots = report.fields.map(({name, label}) => {
    const caption = h('figcaption', {}, label), nothing = nothing_to_plot(name);
    if (nothing) return h('figure', {}, caption, h('p', {}, nothing));
    const words = h('p', {class: 'looked-at'}, 'Point at a mark for its settings; a click finds it in the table.');
    const on_look = index => words.textContent = in_words(report.points[index], name);
    return h('figure', {}, caption, error_plot(report, name, {width: 400, height: 290, time, on_look, on_pick: pick}), words, orders_list(report, name));
  });
  let singled = null;
  const on_series = name => single_out(content, singled = name === singled ? null : name);
  content.append(error_legend(report, {on_series}),
    h('p', {class: 'hint'}, 'A click on a series singles it out. Lines through marks: the spread of the repeats.'), h('div', {class: 'charts'}, plots));
}

const outcomes = report.kind === 'meshing' ? {converged: 'complete', infeasible: 'incomplete', failed: 'failed'}
  : {converged: 'converged', infeasible: 'infeasible', blew_up: 'blew up', too_slow: 'too slow', failed: 'failed'};
/// Two columns: the outcome, and why.
const outcome = point => [outcomes[point.outcome], point.reason];

function say_outcomes() {
  const counts = Object.entries(outcomes).map(([name, words]) => [report.points.filter(point => point.outcome === name).length, words]);
  say('outcomes', `${report.points.length} points: ${counts.filter(([count]) => count > 0).map(([count, words]) => `${count} ${words}`).join(', ')}.`);
}

const range = ({min, max}) => `${digits(min)} – ${digits(max)}`;

/// The plots, and the table of points in which a chosen one is marked.
function draw_points(time, title, head, row, front) {
  say_outcomes();
  let rows = [];
  draw_plots(time, index => {
    rows.forEach((line, k) => line.classList.toggle('picked', k === index));
    rows[index].scrollIntoView({block: 'center'});
  });
  rows = table(title, head, report.points.map(row), k => front.has(k) ? 'front' : '');
}

const names = report.fields?.map(({name}) => name);
const settings = ({solver, springs, substeps, tolerance, resolution}) =>
  `${solver}, ${springs} springs, ${substeps} substeps a frame, tolerance ${digits(tolerance)}, resolution ×${resolution}`;

function say_reference({settings: own, seconds, outcome, reason, errors}) {
  say('reference', `Reference: ${settings(own)}; it took ${digits(seconds)} s. ` +
    `At twice its step its trajectory is ${digits(errors.trajectory_rms)} m (rms) from it. ` +
    'Trajectories: of up to 256 particles of a deformable body and the middles of the six sides of a rigid one\'s box. ' +
    'Times: median over the frames of a run, then over its repeats.');
  if (outcome === 'converged') return;
  say('doubt', `The reference itself ${outcome === 'infeasible' ? 'did not converge' : outcomes[outcome]} (${reason}): errors against it are differences between two runs, no more.`);
}

function draw_scene() {
  say_reference(report.reference);
  if (report.one_lattice) say('one-lattice', `One resolution only: ${report.one_lattice}.`);
  draw_points('ms a step', 'Points (the front of the trajectory error is marked)',
    ['settings', 'substeps', 'outcome', 'why', 'ms a step', 'min – max', '95 % within', 'cells', 'recoveries', ...names],
    p => [p.series, p.settings.substeps, ...outcome(p), p.ms_per_step.median, range(p.ms_per_step), p.ms_p95, p.cells, p.recoveries, ...names.map(name => p.errors[name])],
    new Set(report.fronts.trajectory_rms));
  draw_orders(report.orders);
}

/// A line a series and axis, a column an error.
function draw_orders(orders) {
  const lines = [...new Set(orders.map(({series, axis}) => JSON.stringify([series, axis])))].map(line => JSON.parse(line));
  if (lines.length === 0) return;
  const order_of = (line, name) => orders.find(({series, axis, error}) => error === name && series === line[0] && axis === line[1]);
  const cell = found => found ? `${order_text(found.order)} (${found.points})` : '–';
  table('Orders of convergence (points that each is fitted to)', ['settings', 'in', ...names],
    lines.map(line => [line[0], line[1].replace('_', ' '), ...names.map(name => cell(order_of(line, name)))]));
}

function draw_meshing() {
  draw_points('ms from soup to tets', 'Points (the front of the larger distance is marked)',
    ['settings', 'cells', 'outcome', 'why', 'tets', 'ms', 'min – max', 'volume error', 'boundary → input', 'input → model', 'cell diagonals from the pseudo volume', 'on average', 'coverage', 'smallest dihedral', 'inverted'],
    p => [p.series, p.settings.cells, ...outcome(p), p.tets, p.ms_per_step.median, range(p.ms_per_step), p.volume_error,
      p.errors.boundary_to_input, p.errors.input_to_boundary,
      p.max_diagonals_to_pseudo_volume, p.mean_diagonals_to_pseudo_volume, p.coverage, p.min_dihedral_deg, p.inverted],
    new Set(report.fronts.distance));
}

function draw_stability() {
  const failed = report.cases.filter(({passed}) => !passed).length;
  say('reference', `${report.cases.length - failed} of ${report.cases.length} cases hold.`);
  content.append(h('h2', {}, 'Stiffness over step'),
    h('div', {class: 'charts'}, stability_maps(report.cases).map(map => scrolled(map.caption.textContent, map))));
  table('Cases', ['case', 'holds', 'largest cell error', 'energy ratio', 'inverted', 'recoveries', 's', 'outcome'],
    report.cases.map(c => [`${c.group}: ${c.name}`, c.passed ? '✓' : '✗', c.max_cell_volume_error, c.energy_ratio, c.inverted, c.recoveries, c.seconds, c.outcome]),
    k => report.cases[k].passed ? '' : 'short');
}

function say_proposal() {
  if (report.budget_ms === undefined) return;
  const point = report.points[report.proposal?.point];
  say('proposal', `Within ${report.budget_ms} ms: ${point ? in_words(point, report.fields[0].name) : 'no point of the grid'}.`);
}

const titles = {scene: () => `Error against run time: ${report.scene}`, meshing: () => `Meshing: ${report.input}`, stability: () => 'Stability'};
document.title = say('title', titles[report.kind]());
say('provenance', `${report.machine} · ${report.threads} ${report.threads === 1 ? 'thread' : 'threads'} · ${report.compiler} · Isochor ${report.version} (${report.commit}) · ${report.made.replace('T', ' ').replace('Z', ' UTC')}`);
say_proposal();
document.getElementById('incomplete').hidden = report.complete;
({scene: draw_scene, meshing: draw_meshing, stability: draw_stability})[report.kind]();
