import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {number} from '../ui/format.js';
import {Measuring} from '../work/measuring.js';
import {progress_row} from './report_panel.js';

/// The stiff and extreme suite: a map over stiffness and step, and every other case in words.
export function stability_panel(app) {
  const measuring = new Measuring(app);
  const start = button('Run the stability suite', () => app.run(() => measuring.stability()));
  const result = h('div', {class: 'stability', hidden: true});
  measuring.addEventListener('report', () => {
    const {report} = measuring;
    result.hidden = !report;
    if (!report) return;
    const on_map = report.cases.filter(({h: step}) => Number.isFinite(step));
    const others = report.cases.filter(({h: step}) => !Number.isFinite(step));
    const failed = report.cases.filter(({passed}) => !passed).length;
    result.replaceChildren(stability_map(on_map), case_list(others),
      h('p', {class: 'quiet'}, `${report.cases.length - failed} of ${report.cases.length} cases hold${report.complete ? '' : ' so far'}.`));
  });
  return [h('p', {class: 'quiet'}, 'Stiffness from 0 to 10¹² N/m at steps from 10 µs to 0.1 s, and starts, masses and impacts at their worst.'),
    h('div', {class: 'row'}, start), progress_row(measuring), result];
}

const sorted = values => [...new Set(values)].sort((a, b) => a - b);
const power = value => value === 0 ? '0' : `1e${Math.round(Math.log10(value))}`;
const seconds = step => step > 0.01 && step < 0.02 ? '1/60' : power(step);

function stability_map(cases) {
  const steps = sorted(cases.map(each => each.h));
  const cell = (k, step) => {
    const here = cases.filter(each => each.stiffness === k && each.h === step);
    if (!here.length) return h('td', {});
    const passed = here.every(each => each.passed);
    const error = Math.max(...here.map(each => each.max_cell_volume_error));
    return h('td', {class: passed ? 'good' : 'bad', title: here.map(each => `${each.name}: ${each.outcome}, largest cell error ${number(error)}`).join('\n')},
      `${passed ? '' : '✗ '}${power(Math.max(error, 1e-17))}`);
  };
  return h('table', {class: 'map'}, h('caption', {}, 'Largest cell volume error, stiffness k in N/m over step h in s'),
    h('thead', {}, h('tr', {}, ['k \\ h', ...steps.map(seconds)].map(name => h('th', {scope: 'col'}, name)))),
    h('tbody', {}, sorted(cases.map(each => each.stiffness)).map(k => h('tr', {}, h('th', {scope: 'row'}, power(k)), steps.map(step => cell(k, step))))));
}

const case_list = cases => h('ul', {class: 'cases'}, cases.map(({name, passed, outcome, max_cell_volume_error, energy_ratio, inverted}) =>
  h('li', {}, h('strong', {class: passed ? 'good' : 'bad'}, `${passed ? '✓' : '✗'} ${name}`),
    h('p', {class: 'quiet'}, `${outcome}; cell error ${number(max_cell_volume_error)}, energy ratio ${number(energy_ratio)}, ${number(inverted)} inverted`))));
