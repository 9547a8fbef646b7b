import {h} from '../ui/dom.js';
import {collider_fields} from './collider_fields.js';
import {choice_field, number_field} from '../ui/fields.js';
import {capital, words} from '../ui/format.js';
import {own_scene, scene_templates} from '../state/scene_templates.js';

const volume_solvers = [{value: 'newton', title: 'Newton (exact)'}, {value: 'scaling', title: 'Scaling (paper)'}, {value: 'gradient', title: 'Gradient'}];
const integrators = ['auto', 'symplectic', 'implicit', 'energy_momentum'].map(value => ({value, title: value.replace('_', '–')}));

/// Material, forces, solver and colliders of the scene.
export function scene_stage(app, stage_section) {
  const {store, simulation} = app;
  const badge = h('span', {class: 'stage-state'});
  const show = () => {
    badge.className = `stage-state ${{playing: 'running', none: 'stale', failed: 'failed'}[simulation.state] ?? 'fresh'}`;
    badge.textContent = simulation.state === 'none' ? 'ready' : simulation.state;
  };
  simulation.addEventListener('state', show);
  show();
  const template = choice_field(store, {path: 'template', title: 'Scene', meaning: 'What happens to the body when it is played.',
    choices: [...Object.entries(scene_templates).map(([value, {title}]) => ({value, title})), {value: own_scene, title: ''}]});
  const own = template.querySelector('option:last-of-type');
  const name_own = () => {
    own.hidden = store.get('template') !== own_scene;
    own.textContent = own.hidden ? '' : capital(words(store.get('scene.name') ?? 'opened'));
  };
  store.on(['template', 'scene'], name_own);
  name_own();
  const fields = h('div', {class: 'body-fields'});
  let scope = null;
  const build = () => {
    if (!store.get('scene')) return;
    scope?.dispose();
    scope = store.scope();
    fields.replaceChildren(...scene_fields(scope));
  };
  app.events.addEventListener('scene', build);
  build();
  return stage_section(5, 'Material and scene', badge, template, fields, collider_fields(app));
}

function scene_fields(store) {
  const scene = store.get('scene');
  const index = scene.bodies.findIndex(body => body.type === 'deformable');
  const body = name => `scene.bodies.${index}.${name}`;
  const log = (path, title, unit, min, max, meaning) => number_field(store, {path, title, unit, min, max, step: 'any', logarithmic: true, meaning, fallback: store.get(path)});
  const linear = (path, title, unit, min, max, step, meaning) => number_field(store, {path, title, unit, min, max, step, meaning, fallback: store.get(path)});
  const stiff = (name, title, meaning) => scene.bodies[index]?.[`${name}_modulus`] === undefined
    ? log(body(`${name}_stiffness`), `${title} stiffness`, 'N/m', 1, 1e9, `Of each spring ${meaning}`)
    : log(body(`${name}_modulus`), `${title} modulus`, 'Pa', 1, 1e12, `Of the springs ${meaning} Times a cell’s size it is their stiffness.`);
  return [
    stiff('edge', 'Edge', 'along a cell edge; more keeps the shape, and needs smaller substeps.'),
    stiff('diagonal', 'Diagonal', 'across a cell; more resists shear.'),
    linear(body('damping'), 'Damping', 's', 0, 0.1, 0.001, 'Seconds: the force against a spring’s rate of change is stiffness times this.'),
    log(body('density'), 'Mass density', 'kg/m³', 1, 1e5, 'Mass of a cubic metre; water has 1000.'),
    linear(body('friction'), 'Friction', '', 0, 1.5, 0.05, 'Coulomb coefficient against what the body touches.'),
    linear(body('restitution'), 'Restitution', '', 0, 1, 0.05, 'Share of the approach speed that a bounce gives back.'),
    linear('scene.gravity.1', 'Gravity', 'm/s²', -30, 30, 0.01, 'Acceleration along the vertical; negative pulls down.'),
    choice_field(store, {path: 'scene.solver.volume', title: 'Volume solver', choices: volume_solvers, fallback: 'newton', meaning: 'How the volume of the cells is restored in each substep.'}),
    log('scene.solver.tolerance', 'Tolerance', '', 1e-10, 1e-1, 'Largest relative volume error of a cell that a step may leave.'),
    choice_field(store, {path: 'scene.solver.substeps', title: 'Substeps a frame', choices: ['auto', 1, 2, 4, 8, 16, 32].map(value => ({value, title: String(value)})), fallback: 'auto', meaning: 'Steps between two frames; auto takes as many as stability asks for.'}),
    choice_field(store, {path: 'scene.solver.springs', title: 'Springs', choices: integrators, fallback: 'auto', meaning: 'How the springs are integrated; auto chooses by their stiffness and says why.'}),
  ];
}
