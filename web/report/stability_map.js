// The stability map, shared by the page and the self-contained report: stiffness over step.
import {h} from '../ui/dom.js';

const sorted = values => [...new Set(values)].sort((a, b) => a - b);
const power = value => value === 0 ? '0' : `1e${Math.round(Math.log10(value))}`;
const seconds = step => step > 0.01 && step < 0.02 ? '1/60' : power(step);
const round_off = 1e-17;
const titles = {stiffness: 'Released stretched', landing: 'Dropped on a plane and on a ball'};

/// Whether a case of the suite has its place on the map.
export const on_map = each => Number.isFinite(each.h);

/// One map for each group of cases that have a place on it.
export const stability_maps = cases => [...new Set(cases.filter(on_map).map(each => each.group))]
  .map(group => stability_map(group, cases.filter(each => on_map(each) && each.group === group)));

/// A table: stiffness k in N/m down, step h in s across, in each cell the largest cell volume error and energy ratio of
/// its cases and whether they hold.
function stability_map(group, cases) {
  const steps = sorted(cases.map(each => each.h));
  return h('table', {class: 'map'},
    h('caption', {}, `${titles[group] ?? group}: largest cell volume error, and energy (1 at the start; amber where over half was damped away), stiffness k in N/m over step h in s`),
    h('thead', {}, h('tr', {}, ['k \\ h', ...steps.map(seconds)].map(name => h('th', {scope: 'col'}, name)))),
    h('tbody', {}, sorted(cases.map(each => each.stiffness)).map(k => h('tr', {}, h('th', {scope: 'row'}, power(k)),
      steps.map(step => map_cell(cases.filter(each => each.stiffness === k && each.h === step)))))));
}

function map_cell(cases) {
  if (!cases.length) return h('td');
  const passed = cases.every(each => each.passed);
  const error = Math.max(round_off, ...cases.map(each => each.max_cell_volume_error));
  const energy = Math.max(...cases.map(each => each.energy_ratio));
  const words = cases.map(each => `${each.name}: ${each.outcome}, largest cell error ${each.max_cell_volume_error.toExponential(1)}, ` +
    `energy ${Number(each.energy_ratio?.toPrecision(3))}, ${each.inverted} inverted`);
  return h('td', {class: passed ? energy < 0.5 ? 'damped' : 'good' : 'bad', title: words.join('\n')}, `${passed ? '' : '✗ '}${power(error)}`, h('br'),
    energy < 100 ? energy.toFixed(2) : power(energy));
}
