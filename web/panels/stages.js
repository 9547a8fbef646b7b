import {change, change_text, h} from '../ui/dom.js';
import {calmly} from './calmly.js';
import {choice_field, number_field, toggle_field} from '../ui/fields.js';
import {milliseconds, words} from '../ui/format.js';
import {param_changes, settle} from '../state/constraints.js';
import {input_stage} from './input_stage.js';
import {scene_stage} from './scene_stage.js';
import {threshold_note} from './threshold_note.js';

// What the page calls a stage may be two of the pipeline's.
const sections = [
  {title: 'Pseudo volume', stages: ['distance_field', 'pseudo_volume'], extra: threshold_note},
  {title: 'Lattice', stages: ['lattice', 'tetrahedra']},
  {title: 'Smoothing', stages: ['smoothing', 'embedding']},
];

export function stages_panel(app) {
  const panel = h('aside', {class: 'stages', 'aria-label': 'Stages'});
  panel.append(input_stage(app, stage_section));
  sections.forEach((section, k) => panel.append(meshing_stage(app, section, k + 2)));
  panel.append(scene_stage(app, stage_section));
  return panel;
}

export function stage_section(number, title, badge, ...content) {
  return h('section', {class: 'stage', 'aria-label': title},
    h('details', {open: true}, h('summary', {}, h('h2', {}, `${number}  ${title}`), badge), h('div', {class: 'body'}, content)));
}

function meshing_stage(app, {title, stages, extra}, number) {
  const badge = h('span', {class: 'stage-state'});
  const show = () => {
    const states = stages.map(name => app.meshing.stages[name]);
    const worst = ['failed', 'running', 'stale', 'fresh'].find(state => states.some(stage => stage.state === state));
    const ms = states.reduce((sum, stage) => sum + (stage.reused ? 0 : stage.ms ?? 0), 0);
    const reused = states.every(stage => stage.reused);
    change(badge, {class: `stage-state ${worst}${app.meshing.previewing ? ' brief' : ''}`, title: stages.map(name => describe(name, app.meshing.stages[name])).join('\n')});
    change_text(badge, worst !== 'fresh' ? worst : reused ? 'kept' : milliseconds(ms));
  };
  app.meshing.addEventListener('stages', calmly(app.meshing, show));
  show();
  const fields = app.parameters.filter(({stage}) => stages.includes(stage)).map(parameter => parameter_field(app, parameter));
  return stage_section(number, title, badge, fields, extra?.(app));
}

const describe = (name, {state, ms, reused}) =>
  `${words(name)}: ${state}${ms === null ? '' : `, ${milliseconds(ms)}${reused ? ' when it was made' : ''}`}`;

/// One row of the parameter table as a control.
function parameter_field(app, parameter) {
  const {store} = app;
  const {name, title, meaning, unit, type, choices, fallback} = parameter;
  const path = `params.${name}`;
  if (type === 'boolean') return toggle_field(store, {path, title, meaning, fallback});
  if (type === 'choice') return choice_field(store, {path, title, meaning, fallback, choices: choices.map(value => ({value, title: words(value)}))});
  const field = number_field(store, {...parameter, path, unit: unit === 'deg' ? '°' : unit === 'cells' || unit === title.toLowerCase() ? '' : unit,
    settle: changes => param_changes(settle(store.get('params'), {[name]: changes[path]}))});
  if (fallback === null) hide_while_absent(app, field, name);
  else if (store.get(`params.${twin(name)}`) !== undefined) hide_while_overridden(app, field, name);
  return field;
}

// P_in and P_subs come as distances in voxels, or as probabilities that override them.
const twin = name => name.replace('_voxels', '');

function hide_while_absent({store}, field, name) {
  const show = () => field.hidden = store.get(`params.${name}`) === null;
  store.on('params', show);
  show();
}

function hide_while_overridden({store}, field, name) {
  if (twin(name) === name) return;
  const show = () => field.hidden = store.get(`params.${twin(name)}`) !== null;
  store.on('params', show);
  show();
}
