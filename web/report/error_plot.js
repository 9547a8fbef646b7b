// Error over run time on log-log axes, as SVG: points by series, spreads of the repeats, the
// Pareto front, failures along the top. The points can be walked by arrow keys and chosen.
import {rove} from '../ui/roving.js';

const namespace = 'http://www.w3.org/2000/svg';
const floor = 1e-17;  // round-off: a log axis has no zero
const usable = point => point.outcome === 'converged' || point.outcome === 'infeasible';
const marks = ['circle', 'square', 'diamond', 'triangle'];

function element(tag, attributes, ...children) {
  const made = document.createElementNS(namespace, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/// Series in the order of their first point.
export const series_of = report => [...new Set(report.points.map(point => point.series))];

/// on_pick(index) when a point is clicked, or chosen with Enter.
export function error_plot(report, field, {width = 264, height = 240, on_pick = () => {}, selected = null} = {}) {
  const box = {left: 44, right: width - 8, top: 12, bottom: height - 26};
  const x = scale(report.points.map(point => point.ms_per_step.median).filter(ms => ms > 0), box.left, box.right);
  const y = scale(report.points.filter(usable).map(point => error_of(point, field)), box.bottom, box.top + 10);
  const plot = element('svg', {viewBox: `0 0 ${width} ${height}`, class: 'error-plot', role: 'group', 'aria-label': 'Error over milliseconds a step'});
  const names = series_of(report);
  plot.append(...axis_lines(x, y, box), ...names.map((name, k) => curve(report, field, name, k, x, y)), front_line(report, field, x, y));
  const order = report.points.map((point, index) => ({point, index})).filter(({point}) => point.ms_per_step.median > 0)
    .sort((a, b) => a.point.ms_per_step.median - b.point.ms_per_step.median);
  const dots = order.map(({point, index}) => dot(point, index, field, names.indexOf(point.series), x, usable(point) ? y(error_of(point, field)) : box.top));
  dots.forEach(node => node.classList.toggle('selected', Number(node.dataset.index) === selected));
  plot.append(...dots);
  dots.forEach(node => node.addEventListener('click', () => on_pick(Number(node.dataset.index))));
  rove(dots, {choose: k => on_pick(order[k].index)});
  return plot;
}

const error_of = (point, field) => Math.max(point.errors[field] ?? floor, floor);

function scale(values, from, to) {
  const known = values.length ? values : [1];
  const low = Math.floor(Math.log10(Math.min(...known))), high = Math.ceil(Math.log10(Math.max(...known)) + 1e-9);
  const place = value => from + (to - from) * (Math.log10(value) - low) / Math.max(1, high - low);
  place.decades = Array.from({length: Math.max(1, high - low) + 1}, (_, k) => low + k);
  return place;
}

function axis_lines(x, y, box) {
  const every = decades => decades.filter((_, k) => k % Math.ceil(decades.length / 7) === 0);
  const label = decade => Math.abs(decade) < 3 ? String(Number(`1e${decade}`)) : `1e${decade}`;
  return [
    ...every(x.decades).flatMap(decade => [
      element('line', {x1: x(10 ** decade), x2: x(10 ** decade), y1: box.top, y2: box.bottom, class: 'grid'}),
      element('text', {x: x(10 ** decade), y: box.bottom + 13, 'text-anchor': 'middle'}, label(decade))]),
    ...every(y.decades).flatMap(decade => [
      element('line', {x1: box.left, x2: box.right, y1: y(10 ** decade), y2: y(10 ** decade), class: 'grid'}),
      element('text', {x: box.left - 4, y: y(10 ** decade) + 3, 'text-anchor': 'end'}, label(decade))]),
    element('text', {x: box.right, y: box.bottom + 24, 'text-anchor': 'end'}, 'ms a step'),
  ];
}

const polyline = (points, field, x, y) =>
  points.map((point, k) => `${k ? 'L' : 'M'}${x(point.ms_per_step.median)} ${y(error_of(point, field))}`).join('') || 'M0 0';

function front_line(report, field, x, y) {
  const points = (report.fronts[field] ?? []).map(index => report.points[index]);
  return element('path', {d: polyline(points, field, x, y), class: 'front'});
}

function curve({points}, field, name, series, x, y) {
  const own = points.filter(point => point.series === name && usable(point) && point.ms_per_step.median > 0);
  return element('path', {d: polyline(own, field, x, y), class: `curve series-${series % 6}`});
}

function dot(point, index, field, series, x, at) {
  const {median, min, max} = point.ms_per_step;
  const words = `${point.series}: ${median.toPrecision(3)} ms, error ${usable(point) ? error_of(point, field).toExponential(1) : '–'}, ${point.outcome.replace('_', ' ')}`;
  return element('g', {class: `dot series-${series % 6} ${point.outcome}`, role: 'button', 'aria-label': words, 'data-index': index},
    element('title', {}, words),
    element('line', {x1: x(Math.max(min, median / 10)), x2: x(max), y1: at, y2: at, class: 'spread'}),
    mark(usable(point) ? marks[series % marks.length] : 'cross', x(median), at));
}

function mark(kind, x, y) {
  const paths = {
    circle: `M${x - 4} ${y}a4 4 0 1 0 8 0a4 4 0 1 0-8 0z`, square: `M${x - 3.6} ${y - 3.6}h7.2v7.2h-7.2z`,
    diamond: `M${x} ${y - 5}l5 5-5 5-5-5z`, triangle: `M${x} ${y - 5}l4.6 8.4h-9.2z`, cross: `M${x - 4} ${y - 4}l8 8m0-8l-8 8`,
  };
  return element('path', {d: paths[kind], class: 'mark'});
}
