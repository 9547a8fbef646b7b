import {h, svg} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {menu_button} from '../ui/menu.js';
import {words} from '../ui/format.js';
import {mesh_types} from '../work/scene_meshes.js';

export function header(app) {
  const {store, meshing} = app;
  const name = h('span', {class: 'mesh-name'});
  meshing.addEventListener('mesh', () => name.textContent = app.stem());
  const picker = h('input', {type: 'file', accept: `${mesh_types},.ndjson,.json`, multiple: true, hidden: true, 'aria-label': 'Mesh file'});
  picker.addEventListener('change', () => {
    const files = [...picker.files];
    picker.value = '';  // the same file again is a change as well
    if (files.length) app.open_files(files);
  });
  app.choose_file = () => picker.click();
  const undo = button('', () => app.undo(), {name: 'undo', label: 'Undo'});
  const redo = button('', () => app.redo(), {name: 'redo', label: 'Redo'});
  const show_history = () => {
    const [last, next] = [store.undo_stack.at(-1), store.redo_stack.at(-1)];
    undo.disabled = !last, redo.disabled = !next;
    undo.title = last ? `Undo: ${last.label} (Ctrl+Z)` : 'Undo (Ctrl+Z)';
    redo.title = next ? `Redo: ${next.label} (Ctrl+Shift+Z)` : 'Redo (Ctrl+Shift+Z)';
  };
  store.addEventListener('change', show_history);
  show_history();
  return h('header', {class: 'header', 'aria-label': 'Isochor'},
    h('div', {class: 'brand'}, logo(), h('h1', {}, 'Isochor'), name),
    button('Open', app.choose_file, {name: 'open'}), picker,
    menu_button('Samples', () => sample_items(app)),
    button('Export', () => app.show_export(), {name: 'save'}),
    button('Share', () => app.share()),
    h('div', {class: 'group'}, undo, redo),
    menu_button('Presets', () => preset_items(app)),
    h('span', {class: 'space'}),
    button('Inspector', () => toggle_panel(), {class: 'panel-switch'}),
    button('?', () => app.show_help(), {label: 'Shortcuts and help (?)'}),
    button('', () => app.toggle_theme(), {name: 'theme', label: 'Light or dark'}));
}

function toggle_panel() {
  const on = document.body.dataset.panel === 'inspector';
  document.body.dataset.panel = on ? 'stages' : 'inspector';
}

const logo = () => svg('svg', {viewBox: '0 0 32 32', 'aria-hidden': 'true'},
  svg('path', {d: 'M16 3 29 26H3zM16 3v15M3 26l13-8 13 8', fill: 'none', stroke: 'var(--accent)', 'stroke-width': '2', 'stroke-linejoin': 'round'}));

const sample_items = app => [
  {heading: 'Meshes'},
  ...app.samples.meshes.map(({name, title, meaning}) => ({title: title ?? words(name), note: meaning, run: () => app.open_sample(name)})),
  ...app.samples.scenes.length ? [{heading: 'Scenes'}] : [],
  ...app.samples.scenes.map(scene => ({title: scene.title ?? words(scene.name), run: () => app.open_scene(scene)})),
];

const preset_items = app => app.presets.map(({title, meaning, values}) =>
  ({title, note: meaning, run: () => app.apply_params(values, `preset ${title}`)}));
