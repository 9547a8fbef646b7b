import {h} from '../ui/dom.js';
import {button, number_field} from '../ui/fields.js';

/// The rigid bodies of the scene, each with its place and size; adding and removing them.
export function collider_fields(app) {
  const {store} = app;
  const list = h('div', {class: 'colliders'});
  let scope = null;
  let drawn = '';
  const build = () => {
    const rigid = (store.get('scene')?.bodies ?? []).map((body, index) => ({body, index})).filter(({body}) => body.type === 'rigid');
    const shape = JSON.stringify(rigid.map(({body, index}) => [index, body.name, Object.keys(body.shape)]));
    if (shape === drawn) return;
    drawn = shape;
    scope?.dispose();
    scope = store.scope();
    const opened = new Set([...list.querySelectorAll('[open]')].map(({dataset}) => dataset.name));
    list.replaceChildren(...rigid.map(({body, index}) => collider(app, scope, body, index)));
    for (const entry of list.children) entry.open = opened.has(entry.dataset.name);
  };
  store.on('scene', build);
  app.events.addEventListener('collider', ({detail}) => {
    const chosen = list.querySelector(`[data-body="${detail}"]`);
    if (chosen) chosen.open = true, chosen.scrollIntoView({block: 'nearest'});
  });
  build();
  const add = ['sphere', 'box', 'plane'].map(kind => button(kind, () => {
    app.add_collider(kind);
    show_simulation(store);
  }, {name: 'plus', label: `Add a ${kind}`}));
  return [h('h3', {}, 'Rigid bodies'), list, h('div', {class: 'row'}, add)];
}

/// As a part of the last step: rigid bodies stand in the simulation alone.
function show_simulation(store) {
  const layers = store.get('view.layers');
  if (!layers.sim) store.amend({'view.layers': Object.fromEntries(Object.keys(layers).map(name => [name, name === 'sim']))});
}

function collider(app, scope, body, index) {
  return h('details', {class: 'collider', 'data-body': String(index), 'data-name': body.name},
    h('summary', {}, h('span', {}, body.name)),
    h('div', {class: 'body'}, fields(scope, body, `scene.bodies.${index}`),
      button('Remove', () => app.remove_collider(index), {name: 'trash', label: `Remove ${body.name}`})));
}

function fields(store, body, path) {
  const [[kind]] = Object.entries(body.shape);
  const length = (name, title, min, max) => number_field(store, {path: `${path}.${name}`, title, unit: 'm', min, max, step: 0.01, fallback: store.get(`${path}.${name}`)});
  const place = body.position ? ['X', 'Y', 'Z'].map((axis, k) => length(`position.${k}`, axis, -3, 3)) : [];
  const sizes = {
    sphere: () => [length('shape.sphere.radius', 'Radius', 0.01, 2)],
    capsule: () => [length('shape.capsule.radius', 'Radius', 0.01, 1), length('shape.capsule.half_height', 'Half height', 0.01, 2)],
    box: () => ['Half width', 'Half height', 'Half depth'].map((title, k) => length(`shape.box.half_extents.${k}`, title, 0.01, 2)),
    plane: () => [length('shape.plane.offset', 'Height', -3, 3)],
  };
  return [...place, ...sizes[kind]?.() ?? []];
}
