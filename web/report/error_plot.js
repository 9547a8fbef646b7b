// Error over run time on log-log axes, as SVG: points by series, spreads of the repeats, the Pareto front, a frame
// budget, failures along the top. The points can be walked by arrow keys and chosen. For the page and the
// self-contained report.
import {h, svg} from '../ui/dom.js';
import {rove} from '../ui/roving.js';

/// A finite run; one that is short of its tolerance as well.
export const usable = point => point.outcome === 'converged' || point.outcome === 'infeasible';
const marks = ['circle', 'square', 'diamond', 'triangle'];
const colours = 8, dashes = 3;

/// Series in the order of their first point.
const series_of = report => [...new Set(report.points.map(point => point.series))];

/// How each series is drawn. Its name has parts, "newton · symplectic · 1e-06 · ×0.5": the first two make the colour, the
/// third the mark, the last the dashes of its line, so that what two series share is seen.
function styles_of(report) {
  const names = series_of(report), parts = names.map(name => name.split(' · '));
  const numbered = from_parts => {
    const keys = parts.map(part => from_parts(part) ?? ''), distinct = [...new Set(keys.includes('') ? ['', ...keys] : keys)];
    return keys.map(key => distinct.indexOf(key));
  };
  const colour = numbered(part => part.slice(0, 2).join()), kind = numbered(part => part[2]), dash = numbered(part => part[3]);
  return new Map(names.map((name, k) => [name, {
    name, mark: marks[kind[k] % marks.length], class: `series-${colour[k] % colours} round-${dash[k] % dashes}`}]));
}

// Round-off is plotted as such: a log axis has no zero.
const round_off = 1e-17;
const error_of = (point, field) => Math.max(point.errors[field], round_off);
const plotted = (point, field) => usable(point) && point.errors[field] !== null && point.ms_per_step.median > 0;

/// One point in words.
export function in_words(point, field) {
  const error = usable(point) && point.errors[field] !== null ? point.errors[field].toExponential(1) : '–';
  const {median, min, max} = point.ms_per_step;
  const {substeps, cells} = point.settings;
  const what = [point.series, substeps && `${substeps} substeps`, cells && `${cells} cells`];
  return `${what.filter(Boolean).join(', ')}: ${short(median)} ms (${short(min)} to ${short(max)}), error ${error}, ` +
    `${point.outcome.replace('_', ' ')}`;
}
const short = value => value === null ? '–' : String(Number(value.toPrecision(3)));

/// on_pick(index) when a point is clicked, or chosen with Enter; on_look(index) when it is pointed at or focused.
export function error_plot(report, field, {width = 264, height = 240, time = 'ms a step', on_pick = () => {}, on_look = () => {}, selected = null} = {}) {
  const box = {left: 46, right: width - 8, top: 14, bottom: height - 30};
  const order = report.points.map((point, index) => ({point, index})).filter(({point}) => !usable(point) || plotted(point, field))
    .sort((a, b) => a.point.ms_per_step.median - b.point.ms_per_step.median);
  const times = order.flatMap(({point}) => Object.values(point.ms_per_step)).filter(ms => ms > 0);
  const x = scale(times, box.left, box.right);
  const y = scale(order.filter(({point}) => usable(point)).map(({point}) => error_of(point, field)), box.bottom, box.top + 12);
  const styles = styles_of(report);
  const plot = svg('svg', {viewBox: `0 0 ${width} ${height}`, class: 'error-plot', role: 'group', 'aria-label': `Error over ${time}`},
    axis_lines(x, y, box, time), budget_line(report, x, box), floor_line(floor_of(report, field), y, box), [...styles.values()].map(style => curve(report, field, style, x, y)), front_line(report, field, x, y));
  const dots = order.map(({point, index}) => dot(point, index, field, styles.get(point.series), x, usable(point) ? y(error_of(point, field)) : box.top));
  dots.forEach((node, k) => {
    const {index} = order[k];
    node.classList.toggle('selected', index === selected);
    node.addEventListener('click', () => on_pick(index));
    for (const event of ['pointerenter', 'focus']) node.addEventListener(event, () => on_look(index));
  });
  plot.append(...dots);
  rove(dots, {choose: k => on_pick(order[k].index)});
  return plot;
}

/// What an error has to exceed to be told from round-off and from the error of the reference.
export const floor_of = (report, field) => report.fields.find(({name}) => name === field)?.floor ?? 0;

/// Without a −0.
export const order_text = order => (Math.round(100 * order) / 100 + 0).toFixed(2);

/// The orders of convergence of an error that rest on three points or more, as a list; null without any.
export function orders_list({orders}, field) {
  const fitted = orders.filter(({error, points}) => error === field && points > 2);
  return fitted.length === 0 ? null : h('details', {open: fitted.length < 5, class: 'quiet'}, h('summary', {}, 'Orders of convergence'),
    h('ul', {}, fitted.map(({order, axis, series, points}) => h('li', {}, `${order_text(order)} in ${axis.replace('_', ' ')}: ${series}, ${points} points`))));
}

/// The colours and marks of an error plot's series, and of what else it shows.
/// on_series(name), when given, is called as one is clicked.
export function error_legend(report, {on_series = null} = {}) {
  const sample = (style, ...shown) => svg('svg', {viewBox: '0 0 26 12', class: `error-plot ${style}`, 'aria-hidden': 'true'}, ...shown);
  const item = (name, style, ...shown) => h('li', {}, sample(style, ...shown), name);
  const line = style => svg('path', {d: 'M0 6h26', class: style});
  const series = [...styles_of(report).values()].map(style => {
    const shown = [sample(style.class, line('curve'), mark(style.mark, 13, 6)), style.name];
    return h('li', {}, on_series ? h('button', {type: 'button', 'aria-pressed': 'false', onclick: () => on_series(style.name)}, shown) : shown);
  });
  const has = outcome => report.points.some(point => point.outcome === outcome);
  return h('ul', {class: 'legend'}, series, item('Pareto front', '', line('front')),
    has('infeasible') && item(report.kind === 'meshing' ? 'hollow: an incomplete model' : 'hollow: infeasible, volume or depth was off', 'infeasible', mark('circle', 13, 6)),
    ['blew_up', 'too_slow', 'failed'].some(has) && item('along the top: blew up, was stopped or failed', 'failed', mark('cross', 13, 6)));
}

/// In one or more plots and their legend, only this series stands out; null: all of them.
export function single_out(element, series) {
  for (const each of element.querySelectorAll('[data-series]')) each.classList.toggle('dimmed', series !== null && each.dataset.series !== series);
  for (const button of element.querySelectorAll('.legend button')) button.setAttribute('aria-pressed', String(button.textContent === series));
}

function scale(values, from, to) {
  const known = values.length ? values : [1];
  const [least, most] = [Math.log10(Math.min(...known)), Math.log10(Math.max(...known))];
  const margin = Math.max(0.06 * (most - least), 0.08);
  const [low, high] = [least - margin, most + margin];
  const place = value => from + (to - from) * (Math.log10(value) - low) / (high - low);
  const decades = Array.from({length: Math.floor(high) - Math.ceil(low) + 1}, (_, k) => Math.ceil(low) + k);
  place.ticks = decades.length > 2 ? every(decades).map(decade => [10 ** decade, power(decade)]) : within_decades(low, high, [1, 2, 5]);
  if (place.ticks.length < 2) place.ticks = within_decades(low, high, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
  if (place.ticks.length < 2) place.ticks = [...new Set([least, most])].map(exponent => [10 ** exponent, short(10 ** exponent)]);
  return place;
}

const every = decades => decades.filter((_, k) => k % Math.ceil(decades.length / 7) === 0);
const power = decade => Math.abs(decade) < 3 ? String(Number(`1e${decade}`)) : `1e${decade}`;

/// 1, 2, 5, 10, … for an axis of less than three decades.
function within_decades(low, high, digits) {
  const ticks = [];
  for (let decade = Math.floor(low); decade <= high; ++decade)
    for (const digit of digits) {
      const value = Number(`${digit}e${decade}`);
      if (Math.log10(value) >= low && Math.log10(value) <= high) ticks.push([value, Math.abs(decade) < 3 ? String(value) : `${digit}e${decade}`]);
    }
  return ticks;
}

function axis_lines(x, y, box, time) {
  return [
    ...x.ticks.flatMap(([value, label]) => [
      svg('line', {x1: x(value), x2: x(value), y1: box.top, y2: box.bottom, class: 'grid'}),
      svg('text', {x: x(value), y: box.bottom + 13, 'text-anchor': 'middle'}, label)]),
    ...y.ticks.flatMap(([value, label]) => [
      svg('line', {x1: box.left, x2: box.right, y1: y(value), y2: y(value), class: 'grid'}),
      svg('text', {x: box.left - 4, y: y(value) + 3, 'text-anchor': 'end'}, label)]),
    svg('text', {x: box.right, y: box.bottom + 26, 'text-anchor': 'end'}, time),
  ];
}

function budget_line({budget_ms}, x, box) {
  const at = budget_ms ? x(budget_ms) : NaN;
  if (!(at >= box.left && at <= box.right)) return [];
  return [svg('line', {x1: at, x2: at, y1: box.top, y2: box.bottom, class: 'budget-line'}),
    svg('text', {x: at + 3, y: box.bottom - 4}, `${budget_ms} ms`)];
}

/// Below it errors are those of the reference as well.
function floor_line(floor, y, box) {
  const at = floor > 0 ? y(floor) : NaN;
  if (!(at >= box.top && at <= box.bottom)) return [];
  return [svg('line', {x1: box.left, x2: box.right, y1: at, y2: at, class: 'budget-line'}),
    svg('text', {x: box.right, y: at - 3, 'text-anchor': 'end'}, floor < 1e-13 ? 'round-off' : 'error of the reference')];
}

const polyline = (points, field, x, y) =>
  points.map((point, k) => `${k ? 'L' : 'M'}${x(point.ms_per_step.median)} ${y(error_of(point, field))}`).join('') || 'M0 0';

function front_line(report, field, x, y) {
  const points = (report.fronts[field] ?? []).map(index => report.points[index]);
  return svg('path', {d: polyline(points, field, x, y), class: 'front'});
}

function curve({points}, field, style, x, y) {
  const own = points.filter(point => point.series === style.name && plotted(point, field));
  return svg('path', {d: polyline(own, field, x, y), class: `curve ${style.class}`, 'data-series': style.name});
}

function dot(point, index, field, style, x, at) {
  const {median, min, max} = point.ms_per_step, words = in_words(point, field);
  const left = median > 0 ? x(median) : 46;
  return svg('g', {class: `dot ${style.class} ${point.outcome}`, role: 'button', 'aria-label': words, 'data-index': index, 'data-series': point.series},
    svg('title', {}, words),
    median > 0 ? svg('line', {x1: x(min), x2: x(max), y1: at, y2: at, class: 'spread'}) : [],
    mark(usable(point) ? style.mark : 'cross', left, at));
}

function mark(kind, x, y) {
  const paths = {
    circle: `M${x - 4} ${y}a4 4 0 1 0 8 0a4 4 0 1 0-8 0z`, square: `M${x - 3.6} ${y - 3.6}h7.2v7.2h-7.2z`,
    diamond: `M${x} ${y - 5}l5 5-5 5-5-5z`, triangle: `M${x} ${y - 5}l4.6 8.4h-9.2z`, cross: `M${x - 4} ${y - 4}l8 8m0-8l-8 8`,
  };
  return svg('path', {d: paths[kind], class: 'mark'});
}
