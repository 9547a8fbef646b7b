import {change, change_text, h, svg} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {calmly} from './calmly.js';
import {color_maps, css_color} from '../view/color_maps.js';
import {histogram} from '../view/coloring.js';
import {counted, number} from '../ui/format.js';
import {rove} from '../ui/roving.js';

const bins = 24, width = 264, height = 64;

/// Legend, histogram of what the tets or voxels are coloured by, and a range of it that isolates them in the view.
export function color_panel({store, looking, meshing}) {
  const title = h('h3');
  const plot = svg('svg', {class: 'histogram', viewBox: `0 0 ${width} ${height + 24}`, role: 'group', 'aria-label': 'Histogram'});
  const from = range_input('Lowest value shown'), to = range_input('Highest value shown');
  const clear = button('Show all', () => store.set({'view.select': null}, 'show all'), {class: 'plain'});
  const brush = h('div', {class: 'brush'}, from, h('span', {}, '–'), to, clear);
  const draw = make_histogram(plot, select_by_keys(store));
  const show = () => {
    const {legend: coloring} = looking;
    title.textContent = coloring.values ? `${coloring.title}${coloring.unit ? ` in ${coloring.unit}` : ''}` : why_nothing(store, meshing);
    plot.toggleAttribute('hidden', !coloring.values);
    brush.hidden = !coloring.values;
    if (!coloring.values) return;
    draw(coloring, store.get('view.select'));
    show_range(coloring.scale, store.get('view.select'));
  };
  const show_range = (scale, range) => {
    clear.hidden = !range;
    for (const [input, at] of [[from, range?.from ?? 0], [to, range?.to ?? 1]])
      if (document.activeElement !== input) input.value = Number(value_at(scale, at).toPrecision(3));
  };
  const typed = () => {
    const {scale} = looking.legend;
    const at = input => (exponent(scale, Number(input.value)) - scale.min) / (scale.max - scale.min);
    const [low, high] = [at(from), at(to)];
    if (low < high) store.set({'view.select': {from: low <= 0 ? -1 : low, to: high >= 1 ? 2 : high}}, 'select by value');
  };
  for (const input of [from, to]) input.addEventListener('change', typed);
  brush_by_pointer(plot, store);
  looking.addEventListener('coloring', calmly(meshing, show));
  return h('div', {class: 'color-panel'}, title, plot, brush);
}

function why_nothing(store, {model}) {
  if (!model) return 'No model yet';
  const of_runs = store.get('view.color_by') === 'volume_error';
  return of_runs ? 'Volume errors come with a simulation: play it, and show it as cells' : 'Colour by something to see its distribution';
}

const range_input = label => h('input', {type: 'number', step: 'any', 'aria-label': label});
const value_at = (scale, at) => {
  const value = scale.min + Math.min(1, Math.max(0, at)) * (scale.max - scale.min);
  return scale.logarithmic ? 10 ** value : value;
};
const exponent = (scale, value) => scale.logarithmic ? Math.log10(Math.max(value, 1e-30)) : value;

/// The parts of the histogram are made once; draw(coloring, range) changes what differs.
function make_histogram(plot, keys) {
  const step = width / bins;
  const bars = Array.from({length: bins}, (_, k) => {
    const words = svg('title'), rect = svg('rect', {x: k * step + 0.5, width: step - 1, rx: 1});
    const group = svg('g', {class: 'bin', role: 'button'}, words, svg('rect', {x: k * step, y: 0, width: step, height, fill: 'transparent'}), rect);
    return {group, words, rect};
  });
  rove(bars.map(({group}) => group), keys);
  const ramp = Array.from({length: 48}, (_, k) => svg('rect', {x: k * width / 48, y: height + 2, width: width / 48 + 0.5, height: 6}));
  const ticks = [0, 0.5, 1].map((at, k) => svg('text', {x: at * width, y: height + 20, 'text-anchor': ['start', 'middle', 'end'][k]}));
  plot.replaceChildren(...bars.map(({group}) => group), ...ramp, ...ticks);
  return ({values, scale, unit, nouns}, range) => {
    const map = color_maps[scale.map], counts = histogram(values, scale, bins), most = Math.max(1, ...counts);
    bars.forEach(({group, words, rect}, k) => {
      const n = counts[k], tall = n ? Math.max(2, height * Math.sqrt(n / most)) : 0;
      const inside = !range || ((k + 0.5) / bins >= range.from && (k + 0.5) / bins < range.to);
      const text = `${number(value_at(scale, k / bins))} – ${number(value_at(scale, (k + 1) / bins))}${unit}: ${counted(n, nouns)}`;
      change_text(words, text);
      change(group, {'aria-label': text, 'aria-pressed': String(Boolean(range) && inside)});
      change(rect, {y: height - tall, height: tall, fill: css_color(map, (k + 0.5) / bins), opacity: inside ? 1 : 0.25});
    });
    ramp.forEach((rect, k) => change(rect, {fill: css_color(map, (k + 0.5) / 48)}));
    ticks.forEach((tick, k) => change_text(tick, `${number(value_at(scale, k / 2))}${unit}`));
  };
}

/// Enter selects a bin alone, Shift with the arrows all from there on.
function select_by_keys(store) {
  let anchor = 0;
  const select = k => store.set({'view.select': between(anchor, k)}, 'select by value');
  return {choose: k => select(anchor = k), extend: select};
}

/// The range of the scale that two bins enclose; the outermost ones hold what lies beyond it as well.
function between(one, other) {
  const low = Math.min(one, other), high = Math.max(one, other);
  return {from: low === 0 ? -1 : low / bins, to: high === bins - 1 ? 2 : (high + 1) / bins};
}

/// Dragging over the bins selects a range; a click on one bin selects it alone.
function brush_by_pointer(plot, store) {
  let start = null;
  const bin = event => {
    const box = plot.getBoundingClientRect();
    return Math.min(bins - 1, Math.max(0, Math.floor(bins * (event.clientX - box.left) / box.width)));
  };
  const select = event => {
    store.preview({'view.select': between(start, bin(event))}, 'select by value');
  };
  plot.addEventListener('pointerdown', event => {
    plot.setPointerCapture(event.pointerId);
    start = bin(event);
    select(event);
  });
  plot.addEventListener('pointermove', event => start !== null && select(event));
  plot.addEventListener('pointerup', () => {
    start = null;
    store.commit();
  });
}
