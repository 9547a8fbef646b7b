import {h} from '../ui/dom.js';
import {button, toggle_button} from '../ui/fields.js';
import {tet_scales, voxel_scales} from '../view/coloring.js';

const layer_titles = {surface: 'Surface', voxels: 'Voxels', tets: 'Tets', sim: 'Sim'};

/// Layers, clip, explode and colours, over the view.
export function view_bar(app) {
  const {store} = app;
  const layers = h('div', {class: 'card', role: 'group', 'aria-label': 'Layers'}, h('div', {class: 'group'},
    Object.entries(layer_titles).map(([name, title]) => toggle_button(store, `view.layers.${name}`, title))));
  return h('section', {class: 'view-bar', 'aria-label': 'What is shown'}, layers, clip_card(app), look_card(store));
}

function clip_card({store, viewport}) {
  const on = toggle_button(store, 'view.clip.on', 'Clip');
  const axis = labelled_select(store, 'view.clip.axis', 'Clip axis', {x: 'X', y: 'Y', z: 'Z', free: 'Free'});
  const position = bar_slider(store, 'view.clip.position', 'Clip position');
  const flip = toggle_button(store, 'view.clip.flip', '', {label: 'Flip the clip side', name: 'flip'});
  const mode = labelled_select(store, 'view.clip.mode', 'Clip cells', {whole: 'Whole cells', cut: 'Cut cells'});
  const face = button('Face me', () => face_the_eye(store, viewport), {label: 'Face me: turn the clip plane to the eye'});
  axis.addEventListener('change', () => store.get('view.clip.axis') === 'free' && face_the_eye(store, viewport));
  const parts = [axis, position, flip, mode];
  const show = () => {
    const {on: shown, axis: along} = store.get('view.clip');
    for (const part of parts) part.hidden = !shown;
    face.hidden = !shown || along !== 'free';
  };
  const card = h('div', {class: 'card', role: 'group', 'aria-label': 'Clip plane'}, on, axis, face, position, flip, mode);
  const show_card = () => {
    const {surface, voxels, tets} = store.get('view.layers');
    card.hidden = !surface && !voxels && !tets;  // a simulation is not clipped
  };
  store.on('view.clip', show);
  store.on('view.layers', show_card);
  show();
  show_card();
  return card;
}

function look_card(store) {
  const explode = h('label', {class: 'inline'}, h('span', {}, 'Explode'), bar_slider(store, 'view.explode', 'Explode'));
  const color = labelled_select(store, 'view.color_by', 'Colour tets by', titles(tet_scales));
  const voxels = labelled_select(store, 'view.voxel_color', 'Colour voxels by', titles(voxel_scales));
  const surface = labelled_select(store, 'view.surface_look', 'Show the surface as', {solid: 'Solid surface', glass: 'Glass surface'});
  const sim = labelled_select(store, 'view.sim_look', 'Show the simulation as', {skin: 'Skin', cells: 'Cells'});
  const show = () => {
    const layers = store.get('view.layers');
    explode.hidden = color.hidden = !layers.tets;
    if (layers.sim && store.get('view.sim_look') === 'cells') color.hidden = false;
    voxels.hidden = !layers.voxels;
    surface.hidden = !layers.surface || !(layers.tets || layers.voxels);
    sim.hidden = !layers.sim;
  };
  store.on('view', show);
  show();
  return h('div', {class: 'card', role: 'group', 'aria-label': 'Look'}, color, voxels, surface, sim, explode,
    toggle_button(store, 'view.edges_only', 'Wireframe'));
}

function face_the_eye(store, viewport) {
  const {position, target} = viewport.controls.camera;
  store.set({'view.clip.normal': position.map((x, axis) => Number((x - target[axis]).toFixed(4))), 'view.clip.flip': false}, 'Clip plane');
}

const titles = scales => Object.fromEntries(Object.entries(scales).map(([name, {title}]) => [name, title]));

function labelled_select(store, path, label, options) {
  const select = h('select', {'aria-label': label, title: label}, Object.entries(options).map(([value, title]) => h('option', {value}, title)));
  select.addEventListener('change', () => store.set({[path]: select.value}, label));
  const show = () => select.value = store.get(path);
  store.on(path, show);
  show();
  return select;
}

function bar_slider(store, path, label) {
  const slider = h('input', {type: 'range', min: '0', max: '1', step: '0.005', 'aria-label': label, class: 'bar-slider'});
  slider.addEventListener('input', () => store.preview({[path]: Number(slider.value)}, label));
  slider.addEventListener('change', () => store.commit());
  const show = () => {
    slider.value = store.get(path);
    slider.style.setProperty('--fill', `${100 * slider.value}%`);
  };
  store.on(path, show);
  show();
  return slider;
}

export function camera_bar(app) {
  const {store, viewport} = app;
  return h('div', {class: 'camera-bar'}, h('div', {class: 'card', role: 'group', 'aria-label': 'Camera'},
    button('', () => viewport.fit(), {name: 'fit', label: 'Fit (F)'}),
    h('div', {class: 'group'}, ['Front', 'Right', 'Top'].map(title => button(title, () => app.look_along(title.toLowerCase())))),
    toggle_button(store, 'view.orthographic', 'Ortho', {label: 'Ortho: no perspective (O)'}),
    button('', app.save_screenshot, {name: 'camera', label: 'Save a picture of the view'})));
}
