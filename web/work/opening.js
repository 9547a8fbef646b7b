import {default_state} from '../state/defaults.js';
import {param_changes} from '../state/constraints.js';
import {own_scene} from '../state/scene_templates.js';
import {copy, same} from '../state/store.js';
import {Problem} from '../wire/client.js';

/// Opening meshes, samples, scenes and recordings.
export const opening = app => {
  const {store, meshing, simulation} = app;

  const adopt_scene = () => {
    store.adopt({scene: app.fit_scene()});
    app.tell('scene');
  };

  const open = (source, take) => app.run(async () => {
    await meshing.open(source, take);
    app.tell('solved');
    return true;
  });

  meshing.addEventListener('mesh', () => {
    simulation.forget();
    if (!store.get('mesh.sample')) store.adopt({'mesh.id': meshing.mesh.id});
    if (!store.get('scene') || app.refit) adopt_scene();
    else app.fit_scene();
    app.refit = false;
    if (app.taken) store.remember(app.taken.before, app.taken.label);
    app.taken = null;
  });
  store.on(['template', 'mesh.up', 'mesh.fit', 'mesh.unit'], (_live, replayed) => {
    if (!meshing.mesh || app.restoring || !meshing.shows(store.get('mesh'))) return;
    const scene = app.fit_scene();
    if (!replayed && store.get('template') !== own_scene && !same(scene, store.get('scene'))) store.amend({scene});
    app.tell('scene');
  });
  store.on('mesh', (_live, replayed) => {
    if (replayed && !meshing.shows(store.get('mesh'))) open(store.get('mesh')).then(opened => opened && app.tell('scene'));
  });

  return {
    open,
    open_sample(name) {
      return replace_mesh(app, {sample: name, id: null, name}, app.sample_params(name), {sample: name});
    },
    /// A scene may come with its meshes.
    open_files: files => app.run(async () => {
      const document = files.find(({name}) => /\.json$/i.test(name));
      if (document && files.length > 1) await app.take_meshes(files.filter(file => file !== document));
      return app.open_file(document ?? files[0]);
    }),
    open_file(file) {
      if (/\.ndjson$/i.test(file.name)) return app.replay(file);
      if (/\.json$/i.test(file.name)) return app.run(() => open_settings(app, file));
      return replace_mesh(app, {sample: null, id: null, name: file.name}, app.defaults, {file});
    },
    /// The parameters that a sample starts from.
    sample_params(name) {
      const {preset} = app.samples.meshes.find(sample => sample.name === name) ?? {};
      return {...app.defaults, ...app.presets.find(known => known.name === preset)?.values};
    },
    apply_params(values, label) {
      store.set(param_changes({...app.defaults, ...values}), label);
    },
    fly_to_defect({name, locations}, k) {
      const {viewport} = app;
      if (!store.get('view.layers.surface')) store.set({'view.layers.surface': true}, 'show the surface');
      const point = viewport.model_point(locations[k].map((x, axis) => x - meshing.origin[axis]));
      const radius = 0.08 * viewport.radius();
      viewport.mark(point, radius);
      viewport.fly(point, radius * 2.5);
      app.say(`${name.replaceAll('_', ' ')}: ${k + 1} of ${locations.length}`);
    },
  };
};

/// What belongs to a mesh, and changes with it.
const of_a_mesh = ['mesh', 'params', 'template', 'scene', 'view.camera', 'view.surface_look', 'view.select'];

/// Until the new mesh is known, the last one stands there with all that belongs to it.
async function replace_mesh(app, mesh, params, source) {
  const {store, meshing} = app;
  const turn = app.turn = Symbol(mesh.name);
  let taken = false;
  const take = () => {
    taken = true;
    store.commit();
    const before = Object.fromEntries(of_a_mesh.map(path => [path, copy(store.get(path))]));
    app.taken = meshing.mesh && {before, label: `open ${mesh.name}`};
    const {sim, ...model} = store.get('view.layers');
    const template = store.get('template') === own_scene ? default_state.template : store.get('template');
    app.restoring = meshing.opening = app.refit = true;
    if (!Object.values(model).some(Boolean)) store.adopt({'view.layers': default_state.view.layers});
    store.adopt({'view.camera': null, 'view.surface_look': mesh.sample === 'tree' ? 'solid' : 'glass', 'view.select': null, template,
      mesh: {...default_state.mesh, ...mesh}, params});
    app.restoring = meshing.opening = false;
  };
  await app.open(source, take);
  if (app.turn !== turn || taken) return;  // another is on its way
  const cut_off = Object.values(meshing.stages).some(({state}) => state === 'running');
  if (cut_off || meshing.made_with && !same(store.get('params'), meshing.made_with)) meshing.request(false);
}

/// A params file of the command line, or a scene.
async function open_settings(app, file) {
  const values = read_json(await file.text(), file.name);
  if (Array.isArray(values.bodies)) return app.open_scene_document(values);
  const known = Object.fromEntries(Object.entries(values).filter(([name]) => name in app.defaults));
  if (!Object.keys(known).length) throw new Problem({code: 'cannot_read', file: file.name, title: 'No settings in this file',
    detail: `${file.name} holds neither parameters nor the bodies of a scene.`, hint: 'Export saves the parameters and the scene in the form that is read here.'});
  app.apply_params(known, `settings of ${file.name}`);
  app.say(`Settings of ${file.name} taken`);
}

function read_json(text, name) {
  try {
    const value = JSON.parse(text);
    if (value !== null && typeof value === 'object') return value;
    throw new Error('it holds no object');
  } catch (error) {
    throw new Problem({code: 'cannot_read', file: name, title: 'This is no JSON file', detail: `${name} cannot be read: ${error.message}.`,
      hint: 'Open a params file or a scene as Export saves them.'});
  }
}
