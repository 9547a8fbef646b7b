import {h, unique_id} from '../ui/dom.js';
import {open_dialog} from '../ui/dialog.js';
import {view_keys} from '../work/shortcuts.js';

export function help_dialog(app) {
  const id = unique_id('keys');
  const single = h('input', {type: 'checkbox', id, checked: app.single_keys()});
  single.addEventListener('change', () => localStorage.setItem('isochor-single-keys', single.checked ? 'on' : 'off'));
  const rows = [
    ...app.shortcuts.map(({keys, name, title}) => [keys.map(key => name ?? (key.length === 1 ? key.toUpperCase() : key)), title]),
    ...view_keys.map(([key, title]) => [[key], title])];
  open_dialog('Shortcuts and help',
    h('p', {}, 'Drag to orbit, with Shift or the right button to pan, wheel or pinch to zoom. Click a cell for its values, a voxel for P along its ray. In a simulation, drag the body or a collider; hold Alt to orbit instead.'),
    h('div', {class: 'single-keys'}, single, h('label', {for: id}, 'Single-key shortcuts')),
    h('table', {class: 'keys'}, h('thead', {class: 'visually-hidden'}, h('tr', {}, h('th', {scope: 'col'}, 'Keys'), h('th', {scope: 'col'}, 'Action'))),
      h('tbody', {}, rows.map(([keys, title]) => h('tr', {}, h('td', {}, keys.map(key => h('kbd', {}, key))), h('td', {}, title))))));
}
