// The stability map, shared by the page and the self-contained report: stiffness over step.
const sorted = values => [...new Set(values)].sort((a, b) => a - b);
const power = value => value === 0 ? '0' : `1e${Math.round(Math.log10(value))}`;
const seconds = step => step > 0.01 && step < 0.02 ? '1/60' : power(step);
const floor = 1e-17;  // round-off

/// Whether a case of the suite has its place on the map.
export const on_map = ({h}) => Number.isFinite(h);

/// A table: stiffness k in N/m down, step h in s across, in each cell the largest cell volume error of its cases and
/// whether they hold.
export function stability_map(cases) {
  const steps = sorted(cases.map(each => each.h));
  const table = make('table', {class: 'map'}, make('caption', {}, 'Largest cell volume error, stiffness k in N/m over step h in s'));
  table.append(
    make('thead', {}, make('tr', {}, ...['k \\ h', ...steps.map(seconds)].map(name => make('th', {scope: 'col'}, name)))),
    make('tbody', {}, ...sorted(cases.map(each => each.stiffness)).map(k => make('tr', {}, make('th', {scope: 'row'}, power(k)),
      ...steps.map(step => map_cell(cases.filter(each => each.stiffness === k && each.h === step)))))));
  return table;
}

function map_cell(cases) {
  if (!cases.length) return make('td', {});
  const passed = cases.every(each => each.passed);
  const error = Math.max(floor, ...cases.map(each => each.max_cell_volume_error));
  const words = cases.map(each => `${each.name}: ${each.outcome}, largest cell error ${each.max_cell_volume_error.toExponential(1)}`);
  return make('td', {class: passed ? 'good' : 'bad', title: words.join('\n')}, `${passed ? '' : '✗ '}${power(error)}`);
}

function make(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}
