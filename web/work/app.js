import {Problem} from '../wire/client.js';
import {load} from '../wire/data.js';
import {default_state} from '../state/defaults.js';
import {Store, copy} from '../state/store.js';
import {default_params, read_schema} from '../state/schema.js';
import {Viewport} from '../view/viewport.js';
import {tables} from './first_requests.js';
import {Meshing} from './meshing.js';
import {Playback} from './playback.js';
import {Simulation} from './simulation.js';
import {Looking} from './looking.js';
import {opening} from './opening.js';
import {playing} from './playing.js';
import {exporting} from './exporting.js';
import {picking} from './picking.js';
import {dragging} from './dragging.js';
import {scene_editing} from './scene_editing.js';
import {scene_meshes} from './scene_meshes.js';
import {report_problems} from './problems.js';

/// Everything that the panels share, and what a person can do. Events on `events`: say, problem, solved, scene,
/// picked, ray, theme, server, collider.
export function make_app(client) {
  const store = new Store(copy(default_state));
  const app = {client, store, events: new EventTarget(), meshing: new Meshing(client, store),
    simulation: new Simulation(client), viewport: new Viewport(store), parameters: [], presets: [], samples: {meshes: [], scenes: []}};
  app.playback = new Playback(app.simulation);
  app.looking = new Looking(app);
  app.load = path => load(client, path, 'load', app.meshing.origin);
  app.tell = (name, detail) => app.events.dispatchEvent(new CustomEvent(name, {detail}));
  app.say = text => app.tell('say', text);
  app.run = action => run(app, action);
  for (const room of [playing, opening, exporting, picking, dragging, scene_editing, scene_meshes, history, page]) Object.assign(app, room(app));
  report_problems(app);
  return app;
}

/// Errors of a person's action become a problem card.
async function run(app, action) {
  try {
    return await action();
  } catch (error) {
    if (error.name === 'AbortError') return null;
    if (!(error instanceof Problem) && !error.code) console.error(error);
    app.report(error, () => run(app, action));
    return null;
  }
}

export async function load_tables(app) {
  const [schema, samples] = await Promise.all(tables.map(path => app.client.get(path)));
  app.parameters = read_schema(schema);
  app.presets = schema['x-presets'] ?? [];
  app.samples = samples;
  app.meshing.stage_by_name = Object.fromEntries(app.parameters.map(({name, stage}) => [name, stage]));
  app.defaults = default_params(app.parameters);
  app.store.adopt({params: app.defaults});
}

const history = ({store, say}) => ({
  undo() {
    const label = store.undo_stack.at(-1)?.label;
    store.undo();
    if (label) say(`Undone: ${label}`);
  },
  redo() {
    const label = store.redo_stack.at(-1)?.label;
    store.redo();
    if (label) say(`Redone: ${label}`);
  },
});

const directions = {front: [0, 0, 1], right: [1, 0, 0], top: [0, 1, 1e-3]};

const page = app => ({
  look_along: name => app.viewport.fit(directions[name]),
  single_keys: () => localStorage.getItem('isochor-single-keys') !== 'off',
  cancel() {
    if (!app.meshing.busy && !app.meshing.reading) return;
    app.meshing.cancel();
    app.say('Cancelled; the last model stays');
  },
  escape() {
    if (app.let_go()) return;
    app.viewport.mark(null);
    if (app.picked) app.clear_pick(), app.say('Nothing picked');
    else app.cancel();
  },
  toggle_theme() {
    const root = document.documentElement;
    root.dataset.theme = root.dataset.theme === 'light' ? 'dark' : 'light';
    localStorage.setItem('isochor-theme', root.dataset.theme);
    app.tell('theme');
    app.looking.update();
  },
});
