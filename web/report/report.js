// Draws the report that stands in this document.
import { error_curves, failed_color, group_series } from 'curves';
import { on_map, stability_map } from 'stability_map';

const report = JSON.parse(document.getElementById('report').textContent);
const content = document.getElementById('content');

function add(parent, tag, text = '', attributes = {}) {
  const element = document.createElement(tag);
  element.textContent = text;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  parent.append(element);
  return element;
}

const digits = (value) => (value == null ? '–' : value === 0 ? '0' : Math.abs(value) < 1e-2 || Math.abs(value) >= 1e5 ? value.toExponential(1) : Number(value.toPrecision(3)).toString());

function table(title, head, rows, row_class = () => '') {
  add(content, 'h2', title);
  const element = add(add(content, 'div', '', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': title }), 'table');
  const header = add(add(element, 'thead'), 'tr');
  head.forEach((name, column) => add(header, 'th', name, { scope: 'col', class: typeof rows[0]?.[column] === 'string' ? 'text' : '' }));
  const body = add(element, 'tbody');
  rows.forEach((row, index) => {
    const line = add(body, 'tr', '', { class: row_class(index) });
    for (const cell of row) add(line, 'td', typeof cell === 'number' || cell == null ? digits(cell) : cell, typeof cell === 'string' ? { class: 'text' } : {});
  });
}

function legend(parent, entries) {
  const list = add(parent, 'ul', '', { class: 'legend' });
  for (const [name, color] of entries) {
    const item = add(list, 'li');
    add(item, 'span').style.background = color;
    item.append(name);
  }
}

function draw_curves(time) {
  legend(content, [...group_series(report.points).map((g) => [g.name, g.color]), ['Pareto front', '#888f94'], ['blew up or failed', failed_color]]);
  const charts = add(content, 'div', '', { class: 'charts' });
  const ink = getComputedStyle(document.body).getPropertyValue('--soft').trim();
  for (const { name, label } of report.fields) {
    const figure = add(charts, 'figure');
    add(figure, 'figcaption', label);
    if (report.points.every((p) => !p.errors[name])) { add(figure, 'p', 'Zero, or not defined, at every point.'); continue; }
    error_curves(figure, report, name, { width: Math.max(280, figure.clientWidth - 26), height: 280, ink, time });
    for (const o of report.orders.filter((each) => each.error === name && each.points > 2))
      add(figure, 'p', `order ${o.order.toFixed(2)} in ${o.axis}: ${o.series}, ${o.points} points`);
  }
}

const outcomes = { converged: 'converged', infeasible: 'infeasible', blew_up: 'blew up', failed: 'failed' };
const outcome = (p) => (p.reason ? `${outcomes[p.outcome]}: ${p.reason}` : outcomes[p.outcome]);
const range = ({ min, max }) => `${digits(min)} – ${digits(max)}`;

function draw_scene() {
  draw_curves('ms a step');
  const front = new Set(report.fronts.trajectory_rms);
  table('Points (the front of the trajectory error is marked)',
    ['settings', 'substeps', 'ms a step', 'min – max', ...report.fields.map((f) => f.name), 'outcome'],
    report.points.map((p) => [p.series, p.substeps, p.ms_per_step.median, range(p.ms_per_step),
      ...report.fields.map((f) => p.errors[f.name]), outcome(p)]),
    (index) => (front.has(index) ? 'front' : ''));
  if (report.orders.length > 0)
    table('Orders of convergence', ['series', 'error', 'axis', 'order', 'points'],
      report.orders.map((o) => [o.series, o.error, o.axis, o.order, o.points]));
}

function draw_meshing() {
  draw_curves('ms from soup to tets');
  table('Points',
    ['settings', 'cells', 'tets', 'ms', 'min – max', 'volume error', 'boundary → input', 'input → boundary', 'coverage', 'smallest dihedral', 'inverted', 'outcome'],
    report.points.map((p) => [p.series, p.settings.cells, p.tets, p.ms_per_step.median, range(p.ms_per_step), p.volume_error,
      p.errors.boundary_to_input, p.errors.input_to_boundary, p.coverage, p.min_dihedral_deg, p.inverted, outcome(p)]));
}

function draw_stability() {
  add(content, 'h2', 'Stiffness over step');
  add(content, 'div', '', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Stiffness over step' }).append(stability_map(report.cases.filter(on_map)));
  table('Cases', ['case', 'passed', 'largest cell error', 'energy ratio', 'inverted', 'recoveries', 's', 'outcome'],
    report.cases.map((c) => [`${c.group}: ${c.name}`, c.passed ? '✓' : '✗', c.max_cell_volume_error, c.energy_ratio, c.inverted, c.recoveries, c.seconds, c.outcome]));
}

const titles = { scene: () => `Error against run time: ${report.scene}`, meshing: () => `Meshing: ${report.input}`, stability: () => 'Stability' };
document.title = document.getElementById('title').textContent = titles[report.kind]();
document.getElementById('provenance').textContent = `${report.machine} · ${report.compiler} · Isochor ${report.version} (${report.commit})`;
document.getElementById('incomplete').hidden = report.complete;
({ scene: draw_scene, meshing: draw_meshing, stability: draw_stability })[report.kind]();
