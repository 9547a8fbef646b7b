import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {counted, number} from '../ui/format.js';
import {on_map, stability_maps} from '../report/stability_map.js';
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
    const failed = report.cases.filter(({passed}) => !passed).length;
    result.replaceChildren(...stability_maps(report.cases), case_list(report.cases.filter(each => !on_map(each))),
      h('p', {class: 'quiet'}, `${report.cases.length - failed} of ${counted(report.cases.length, 'cases')} hold${report.complete ? '' : ' so far'}.`));
  });
  return [h('p', {class: 'quiet'}, 'Stiffness from 0 to 10¹² N/m at steps from 10 µs to 0.1 s, and starts, masses and impacts at their worst.'),
    h('div', {class: 'row'}, start), progress_row(measuring), result];
}

const case_list = cases => h('ul', {class: 'cases'}, cases.map(({name, passed, outcome, max_cell_volume_error, energy_ratio, inverted}) =>
  h('li', {}, h('strong', {class: passed ? 'good' : 'bad'}, `${passed ? '✓' : '✗'} ${name}`),
    h('p', {class: 'quiet'}, `${outcome}; cell error ${number(max_cell_volume_error)}, energy ratio ${number(energy_ratio)}, ${number(inverted)} inverted`))));
