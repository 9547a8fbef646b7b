import {h} from '../ui/dom.js';
import {button, choice_field, toggle_field} from '../ui/fields.js';
import {count, counted, number, words} from '../ui/format.js';

const units = [{value: 1, title: 'metres'}, {value: 0.01, title: 'centimetres'}, {value: 0.001, title: 'millimetres'}, {value: 0.0254, title: 'inches'}];

/// The mesh: what it is, how it is taken, what is wrong with it and where.
export function input_stage(app, stage_section) {
  const {store, meshing} = app;
  const badge = h('span', {class: 'stage-state'});
  const facts = h('dl', {class: 'facts'});
  const defects = h('ul', {class: 'defects'});
  const unit = choice_field(store, {path: 'mesh.unit', title: 'File unit', choices: units, fallback: 1,
    meaning: 'What one unit of the file is in the simulated world.'});
  const show = () => {
    const {mesh} = meshing;
    badge.className = `stage-state ${mesh ? 'fresh' : 'stale'}`;
    badge.textContent = mesh ? counted(mesh.report.triangles, 'triangles') : '';
    if (mesh) fill_report(app, mesh.report, facts, defects);
  };
  const show_unit = () => unit.hidden = store.get('mesh.fit');
  meshing.addEventListener('mesh', show);
  store.on('mesh', show_unit);
  show();
  show_unit();
  return stage_section(1, 'Input', badge,
    toggle_field(store, {path: 'mesh.fit', title: 'Fit to one metre', fallback: true, meaning: 'Scales the body so that its longest edge is one metre.'}),
    unit,
    choice_field(store, {path: 'mesh.up', title: 'Up axis of the file', choices: [{value: 'y', title: 'Y'}, {value: 'z', title: 'Z'}], fallback: 'y',
      meaning: 'The direction that gravity pulls against.'}),
    facts, defects);
}

function fill_report(app, report, facts, defects) {
  const size = report.bounds.max.map((x, axis) => x - report.bounds.min[axis]);
  const rows = [['Vertices', count(report.vertices)], ['Components', count(report.components)],
    ['Size', size.map(x => number(x)).join(' × ')], ['Area', number(report.area)],
    report.closed ? ['Volume', `${number(Math.abs(report.volume))}${report.volume < 0 ? ', inside out' : ''}`] : ['Closed', 'no']];
  facts.replaceChildren(...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
  defects.replaceChildren(...report.defects.filter(defect => defect.count > 0).map(defect => defect_row(app, defect)));
}

function defect_row(app, defect) {
  let next = 0;
  const title = counted(defect.count, words(defect.name));
  if (!defect.locations?.length) return h('li', {}, title);
  const fly = () => app.fly_to_defect(defect, next++ % defect.locations.length);
  return h('li', {}, button(title, fly, {name: 'target', class: 'plain defect', label: `${title}: fly to the next`}));
}
