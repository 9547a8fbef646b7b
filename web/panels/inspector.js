import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {bytes, count, counted, number, percent, sentence} from '../ui/format.js';
import {in_titles} from '../state/suggestions.js';
import {calmly} from './calmly.js';
import {color_panel} from './color_panel.js';
import {plan_panel} from './plan_panel.js';
import {picked_panel} from './picked_panel.js';
import {report_panel} from './report_panel.js';
import {stability_panel} from './stability_panel.js';
import {live_plots} from './live_plots.js';

export function inspector(app) {
  const live = panel('Simulation', live_plots(app)), picked = panel('Picked', picked_panel(app));
  const root = h('aside', {class: 'inspector', 'aria-label': 'Inspector'},
    panel('Model', model_facts(app)),
    panel('Quality', color_panel(app)),
    picked,
    live,
    panel('Plan', plan_panel(app)),
    panel('Error against run time', report_panel(app)),
    panel('Stability', stability_panel(app)));
  const {simulation} = app;
  simulation.addEventListener('bodies', () => {
    if (simulation.bodies.length && !simulation.continued) root.scrollTo({top: live.offsetTop - root.offsetTop});
  });
  app.events.addEventListener('ray', () => reveal(root, picked));
  return root;
}

/// Scrolls the inspector, where it scrolls by itself, until all of the panel is seen.
function reveal(root, {offsetTop, offsetHeight}) {
  const top = offsetTop - root.offsetTop, below = top + offsetHeight - root.clientHeight;
  root.scrollTo({top: Math.max(Math.min(root.scrollTop, top), below)});
}

export const panel = (title, ...content) =>
  h('section', {class: 'panel', 'aria-label': title},
    h('details', {open: true}, h('summary', {}, h('h2', {}, title)), h('div', {class: 'body'}, content)));

function model_facts(app) {
  const {meshing} = app;
  const none = h('p', {class: 'quiet'}, 'No model yet.');
  const facts = h('dl', {class: 'facts'});
  const notes = model_notes(app);
  const show = () => {
    none.hidden = Boolean(meshing.model);
    facts.hidden = !meshing.model;
  };
  meshing.addEventListener('mesh', show);
  meshing.addEventListener('model', calmly(meshing, () => {
    const {model} = meshing, known = value => value !== undefined;  // a preview knows less
    const rows = [['Cells', count(model.cells)], ['Tets', count(model.tets)], ['Vertices', count(model.vertices)],
      ['Components', count(model.components)], ['Volume', number(model.volume, 4)],
      ['Coverage', known(model.coverage) ? percent(model.coverage) : '…'],
      ['Smallest dihedral', `${number(model.min_dihedral_deg)}°`], ['Worst scaled Jacobian', number(model.min_scaled_jacobian)],
      ['Inverted', count(model.inverted)],
      ...[['Off the pseudo volume', model.max_diagonals_to_pseudo_volume], ['On average', model.mean_diagonals_to_pseudo_volume]]
        .map(([name, value]) => [name, known(value) ? `${number(value, 2)} diagonals` : '…']),
      ...model.bytes ? [['Memory', bytes(model.bytes)]] : []];
    facts.replaceChildren(...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
    show();
  }));
  show();
  return [none, facts, notes];
}

/// What to know before trusting the model, folded away while the model is complete.
function model_notes(app) {
  const {meshing} = app;
  const title = h('span');
  const list = h('ul');
  const notes = h('details', {class: 'notes'}, h('summary', {}, title), list);
  let complete = true;
  meshing.addEventListener('mesh', () => notes.hidden = !meshing.model);
  meshing.addEventListener('model', () => {
    const {warnings, complete: whole} = meshing.model;
    if (whole === undefined) return;  // a preview, which does not know
    title.textContent = whole ? counted(warnings.length, 'notes') : 'This model is incomplete';
    title.className = whole ? '' : 'warn';
    if (complete && !whole) notes.open = true;
    complete = whole;
    notes.hidden = !warnings.length;
    list.replaceChildren(...warnings.map(warning => h('li', {}, h('p', {}, sentence(in_titles(warning, app))),
      app.ways_from_text(warning).map(({title: way, run}) => button(way, run)))));
  });
  return notes;
}
