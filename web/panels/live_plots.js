import uPlot from 'uplot';
import {h, once_a_frame} from '../ui/dom.js';
import {theme_color} from '../ui/theme.js';
import {number} from '../ui/format.js';

const span = 600;  // frames kept in view
const shortest = 0.1;  // seconds that a plot shows at least

const plots = [
  {title: 'Volume error', logarithmic: true, series: [['total', m => Math.max(m.total_volume_error, 1e-17)], ['largest cell', m => Math.max(m.max_cell_volume_error, 1e-17)]]},
  {title: 'Energy, J', series: [['kinetic', m => m.kinetic_energy], ['potential', m => m.potential_energy], ['sum', m => m.kinetic_energy + m.potential_energy]]},
  {title: 'Step, ms', series: [['step', m => m.step_ms]]},
  {title: 'Substeps', series: [['substeps', m => m.substeps], ['iterations', m => m.iterations]]},
];

/// Metrics of the frames as they come, over simulated time.
export function live_plots({simulation, events}) {
  const root = h('div', {class: 'plots'});
  const facts = h('dl', {class: 'facts'});
  const hint = h('p', {class: 'quiet'}, 'Play the scene to see its volume error, energy, time and substeps.');
  let charts = null;
  let data = [];
  simulation.addEventListener('bodies', () => {
    hint.hidden = simulation.bodies.length > 0;
    if (simulation.continued) return;
    data = [];
    if (!hint.hidden) take_away(), facts.replaceChildren();
  });
  let pending = false;
  simulation.addEventListener('frames', () => {
    const {seq, t, metrics} = simulation.buffer.last ?? {};
    if (!metrics) return;
    while (data.length && data.at(-1).seq >= seq) data.pop();
    data.push({seq, t, metrics});
    if (data.length > span) data.shift();
    if (pending) return;
    pending = true;
    setTimeout(() => {
      pending = false;
      if (data.length) draw();
    }, 200);
  });
  const draw = () => {
    charts ??= plots.map(plot => make_chart(root, plot));
    charts.forEach((chart, k) => chart.setData([data.map(({t}) => t), ...plots[k].series.map(([, read]) => data.map(({metrics}) => read(metrics)))]));
  };
  simulation.addEventListener('frame', once_a_frame(() => show_facts(facts, simulation.shown?.metrics)));
  const take_away = () => {
    charts?.forEach(chart => (chart.root.parentNode.remove(), chart.destroy()));
    charts = null;
  };
  events.addEventListener('theme', () => {
    take_away();
    if (data.length) draw();
  });
  new ResizeObserver(() => charts?.forEach(chart => chart.setSize({width: root.clientWidth, height: scaled(100)}))).observe(root);
  return [hint, facts, root];
}

function show_facts(facts, m) {
  if (!m) return;
  const held = m.feasible === false ? h('span', {class: 'bad'}, 'not held') : 'held';
  const rows = [['Largest cell error', number(m.max_cell_volume_error)], ['Volume and depth', held], ['Total error', number(m.total_volume_error)],
    ['Inverted tets', number(m.inverted)], ['Contacts', number(m.contacts)], ['Deepest penetration', `${number(m.max_penetration)} m`],
    ['Recoveries', number(m.recoveries)]];
  facts.replaceChildren(...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
}

/// Of the times themselves: uPlot makes a hundred of a single one.
function range({data: [times]}) {
  const from = times[0] ?? 0;
  return [from, Math.max(times.at(-1) ?? 0, from + shortest)];
}

/// Three to five powers of ten.
const decades = {
  splits(_plot, _axis, low, high) {
    const [from, to] = [Math.ceil(Math.log10(low)), Math.floor(Math.log10(high))];
    const step = Math.max(1, Math.ceil((to - from) / 4));
    return Array.from({length: Math.floor((to - from) / step) + 1}, (_, k) => 10 ** (from + k * step));
  },
  filter: (_plot, ticks) => ticks,
  values: (_plot, ticks) => ticks.map(tick => `1e${Math.round(Math.log10(tick))}`),
};

/// Pixels for as many of a text of 13 pixels.
const scaled = pixels => pixels * Number.parseFloat(getComputedStyle(document.documentElement).fontSize) / 13;

function make_chart(root, {title, logarithmic, series}) {
  const strokes = [theme_color('--accent'), theme_color('--warn'), theme_color('--muted')];
  const axis = {stroke: theme_color('--muted'), grid: {stroke: theme_color('--line'), width: 1}, ticks: {show: false}, font: `${scaled(10)}px system-ui`, size: scaled(18)};
  const holder = h('figure', {class: 'plot', 'aria-label': title}, h('figcaption', {}, title, ...series.map(([name], k) =>
    h('span', {class: `key key-${k}`}, name))));
  root.append(holder);
  return new uPlot({
    width: root.clientWidth || 260, height: scaled(100), legend: {show: false}, cursor: {show: false}, padding: [8, 12, 0, 0],
    scales: {x: {time: false, range}, y: logarithmic ? {distr: 3} : {}},
    axes: [{...axis}, {...axis, size: scaled(46), ...logarithmic ? decades : {values: (_, ticks) => ticks.map(tick => number(tick, 2))}}],
    series: [{}, ...series.map(([name], k) => ({label: name, stroke: strokes[k], width: 1.5, points: {show: false}}))],
  }, [[], ...series.map(() => [])], holder);
}
