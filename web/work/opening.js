import {default_state} from '../state/defaults.js';
import {param_changes} from '../state/constraints.js';
import {Problem} from '../wire/client.js';

/// Opening meshes, samples, scenes and recordings.
export const opening = app => {
  const {store, meshing, simulation} = app;

  const adopt_scene = () => {
    store.adopt({scene: app.fit_scene()});
    app.tell('scene');
  };

  const open = source => app.run(async () => {
    await simulation.close();
    simulation.set_state('none');
    await meshing.open(source);
    app.tell('solved');
    return true;
  });

  meshing.addEventListener('mesh', () => {
    if (!store.get('scene') || app.refit) adopt_scene();
    else app.fit_scene();
    app.refit = false;
  });
  const refit_by_person = () => {
    if (!meshing.mesh || app.restoring) return;
    const scene = app.fit_scene();
    if (JSON.stringify(scene) === JSON.stringify(store.get('scene'))) return;
    adopt_scene();
  };
  store.on(['template', 'mesh.up', 'mesh.fit', 'mesh.unit'], refit_by_person);

  return {
    open,
    open_sample(name) {
      return replace_mesh(app, {sample: name, id: null, name}, app.sample_params(name), {sample: name});
    },
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
      const point = viewport.model_point(locations[k]);
      const radius = 0.08 * viewport.radius();
      viewport.mark(point, radius);
      viewport.fly(point, radius * 2.5);
      app.say(`${name.replaceAll('_', ' ')}: ${k + 1} of ${locations.length}`);
    },
  };
};

async function replace_mesh(app, mesh, params, source) {
  const {store} = app;
  const before = {mesh: structuredClone(store.get('mesh')), params: structuredClone(store.get('params'))};
  app.meshing.opening = true;
  app.restoring = true;
  store.adopt({'view.camera': null, 'view.surface_look': mesh.sample === 'tree' ? 'solid' : 'glass', 'view.select': null, mesh: {...default_state.mesh, ...mesh}, params});
  app.restoring = false;
  app.refit = true;
  if (!await app.open(source)) {
    app.restoring = true;
    app.meshing.opening = true;
    store.adopt(before);
    app.restoring = app.meshing.opening = app.refit = false;
    return;
  }
  if (!mesh.sample) store.adopt({'mesh.id': app.meshing.mesh.id});
}

/// A params file of the command line, or a scene.
async function open_settings(app, file) {
  const values = read_json(await file.text(), file.name);
  if (Array.isArray(values.bodies)) return app.open_scene_document(values);
  const known = Object.fromEntries(Object.entries(values).filter(([name]) => name in app.defaults));
  if (!Object.keys(known).length) throw new Problem({code: 'cannot_read', title: 'No settings in this file',
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
    throw new Problem({code: 'cannot_read', title: 'This is no JSON file', detail: `${name} cannot be read: ${error.message}.`,
      hint: 'Open a params file or a scene as Export saves them.'});
  }
}
