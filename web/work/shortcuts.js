import {dismiss_tooltip} from '../ui/fields.js';
import {camera_key} from '../view/camera_controls.js';

/// Single keys, wherever no text is being typed; they can be turned off (WCAG 2.1.4).
export const shortcuts = app => {
  const {store, viewport} = app;
  const flip = (path, title) => () => {
    store.set({[path]: !store.get(path)}, title);
    app.say(`${title} ${store.get(path) ? 'on' : 'off'}`);
  };
  const clip = (changes, label) => {
    store.set({'view.clip.on': true, ...changes}, label);
    const {axis, position} = store.get('view.clip');
    app.say(`Clipped along ${axis.toUpperCase()} at ${Math.round(100 * position)} %`);
  };
  const clip_by = step => clip({'view.clip.position': Math.min(1, Math.max(0, store.get('view.clip.position') + step))}, 'Clip position');
  return [
    {keys: [' '], title: 'Play or pause', name: 'Space', run: app.toggle_play},
    {keys: ['.'], title: 'Step forward', run: () => app.step(1)},
    {keys: [','], title: 'Step back', run: () => app.step(-1)},
    {keys: ['Home'], title: 'Restart', run: app.restart},
    {keys: ['r'], title: 'Record, or stop recording', run: app.toggle_recording},
    {keys: ['1'], title: 'Surface on or off', run: flip('view.layers.surface', 'Surface')},
    {keys: ['2'], title: 'Voxels on or off', run: flip('view.layers.voxels', 'Voxels')},
    {keys: ['3'], title: 'Tets on or off', run: flip('view.layers.tets', 'Tets')},
    {keys: ['4'], title: 'Simulation on or off', run: flip('view.layers.sim', 'Simulation')},
    {keys: ['c'], title: 'Clip on or off', run: flip('view.clip.on', 'Clip')},
    {keys: ['x', 'y', 'z'], title: 'Clip along X, Y or Z', run: key => clip({'view.clip.axis': key}, 'Clip axis')},
    {keys: ['[', ']'], title: 'Move the clip plane', run: key => clip_by(key === '[' ? -0.05 : 0.05)},
    {keys: ['w'], title: 'Wireframe', run: flip('view.edges_only', 'Wireframe')},
    {keys: ['f'], title: 'Fit the view', run: () => viewport.fit()},
    {keys: ['o'], title: 'Orthographic or perspective', run: flip('view.orthographic', 'Orthographic view')},
    {keys: ['6', '7', '8'], title: 'Look from the front, the right or the top', run: key => app.look_along({6: 'front', 7: 'right', 8: 'top'}[key])},
    {keys: ['p'], title: 'Pick what stands in the middle of the view', run: app.pick_middle},
    {keys: ['g'], title: 'Grab the body or collider in the middle of the view; arrows and Page Up/Down pull, Escape lets go', run: app.grab_middle},
    {keys: ['e'], title: 'Export', run: app.show_export},
    {keys: ['t'], title: 'Light or dark', run: app.toggle_theme},
    {keys: ['?'], title: 'This list', run: app.show_help},
  ];
};

export const view_keys = [
  ['Arrow keys', 'Orbit (with the view focused)'], ['Shift + arrow keys', 'Pan'], ['+ and −', 'Zoom'],
  ['Ctrl + Z', 'Undo'], ['Ctrl + Shift + Z', 'Redo'], ['Escape', 'Cancel the work under way, let go, close'],
];

export function listen_to_keys(app) {
  const table = app.shortcuts = shortcuts(app);
  addEventListener('keydown', event => {
    if (undo_key(app, event) || event.defaultPrevented || document.querySelector('dialog[open]')) return;
    if (event.key === 'Escape') return dismiss_tooltip(), app.escape();
    if (app.grab_key(event)) return event.preventDefault();
    const in_view = document.activeElement === app.viewport.canvas;
    if (in_view && camera_key(app.viewport.controls, event)) return event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event) || !app.single_keys()) return;
    const entry = table.find(({keys}) => keys.includes(event.key) || keys.includes(event.key.toLowerCase()));
    if (!entry) return;
    event.preventDefault();
    entry.run(event.key.toLowerCase());
  });
}

function undo_key(app, event) {
  if (!(event.ctrlKey || event.metaKey) || typing_text(event.target)) return false;
  const key = event.key.toLowerCase();
  if (key !== 'z' && key !== 'y') return false;
  event.preventDefault();
  if (key === 'y' || event.shiftKey) app.redo();
  else app.undo();
  return true;
}

const typing_text = element => element.matches?.('input[type=number], input[type=text], textarea');

/// Keys that the focused control uses itself.
function typing({target, key}) {
  if (typing_text(target) || target.matches?.('select')) return true;
  if (key === ' ') return Boolean(target.closest?.('button, summary, input:not([type=range]), a'));
  return target.matches?.('input[type=range]') && ['Home', ',', '.'].includes(key);
}
