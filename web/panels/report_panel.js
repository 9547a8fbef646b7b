import {h, unique_id} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {about, counted, number} from '../ui/format.js';
import {redraw} from '../ui/roving.js';
import {error_legend, error_plot, orders_list} from '../report/error_plot.js';
import {same} from '../state/store.js';
import {Measuring, fit_budget, settings_changes, worth_measuring} from '../work/measuring.js';

/// Error against run time: measure, look, click a point to take its settings, or let a frame budget choose.
export function report_panel(app) {
  const measuring = new Measuring(app);
  const field = h('select', {'aria-label': 'Error shown'});
  const plot = h('div');
  const progress = progress_row(measuring);
  const budget = budget_row(measuring, field, point => take(point));
  const size = h('select', {'aria-label': 'Grid of settings'}, h('option', {value: 'quick'}, 'Quick grid'), h('option', {value: 'full'}, 'Full grid'));
  const seconds = h('input', {type: 'number', min: '0.02', max: '60', step: 'any', required: true, 'aria-label': 'Simulated seconds to measure'});
  const propose = () => seconds.value = worth_measuring(size.value, app.store.get('scene'));
  size.addEventListener('change', propose);
  app.events.addEventListener('scene', propose);
  propose();
  const measure = () => seconds.reportValidity() && app.run(() => measuring.scene(size.value, Number(seconds.value)));
  const start = button('Measure', measure, {label: 'Measure error against run time'});
  const result = h('div', {class: 'report', hidden: true}, field, plot, budget);
  const take = ({settings, series}) => {
    app.store.set(settings_changes(settings), 'settings of a measured point');
    app.say(`Taken: ${series}`);
    measuring.selected = measuring.report.points.findIndex(point => same(point.settings, settings));
    draw();
  };
  const draw = () => {
    const {report} = measuring;
    result.hidden = !report?.points.length;
    if (result.hidden) return;
    redraw(plot, () => plot.replaceChildren(...[error_plot(report, field.value, {on_pick: index => take(report.points[index]), selected: measuring.selected}), error_legend(report),
      orders_list(report, field.value)].filter(Boolean)));
  };
  measuring.addEventListener('report', () => {
    const {report} = measuring;
    if (!report) measuring.selected = null;
    if (report && !field.length) field.append(...report.fields.map(({name, label}) => h('option', {value: name}, label)));
    draw();
  });
  field.addEventListener('change', draw);
  return [h('p', {class: 'quiet'}, 'Runs the scene over solvers, steps and tolerances against a far finer reference.'),
    h('div', {class: 'row'}, size, h('span', {class: 'seconds'}, seconds, h('span', {class: 'quiet'}, 's')), start), progress, result];
}

export function progress_row(measuring) {
  const bar = h('progress', {max: '1', 'aria-label': 'Progress of the measurement'});
  const text = h('span', {class: 'quiet'});
  const row = h('div', {class: 'row', hidden: true}, bar, text, button('Cancel', () => measuring.cancel()));
  measuring.addEventListener('progress', () => {
    const {job} = measuring;
    row.hidden = !job;
    if (!job) return;
    bar.value = job.fraction ?? 0;
    text.textContent = job.eta_s ? `${about(job.eta_s)} left` : job.phase;
  });
  return row;
}

function budget_row(measuring, field, take) {
  const id = unique_id('budget');
  const limit = h('input', {type: 'number', id, min: '1e-6', step: 'any', required: true, value: '8'});
  const answer = h('p');
  const fit = () => {
    if (!limit.reportValidity()) return;
    const point = fit_budget(measuring.report, field.value, Number(limit.value));
    if (!point) return answer.replaceChildren(`No measured setting converges within ${limit.value} ms.`);
    const {series, settings: {substeps}, ms_per_step: {median}, fits_ms} = point;
    answer.replaceChildren(`${series}, ${counted(substeps, 'substeps')}: ${number(median)} ms, with reserve ${number(fits_ms)} ms, error ${number(point.errors[field.value])} `, button('Use', () => take(point), {label: 'Use these settings'}));
  };
  limit.addEventListener('keydown', ({key}) => key === 'Enter' && fit());
  measuring.addEventListener('report', () => measuring.report || answer.replaceChildren());
  return h('div', {class: 'budget'}, h('label', {for: id}, 'Fit my budget'), limit, h('span', {class: 'quiet'}, 'ms/step'), button('Fit', fit), answer);
}
