import {wire_scene} from '../state/scene_templates.js';
import {download} from '../ui/dom.js';
import {same} from '../state/store.js';

// Changes of the scene that a running simulation takes at once; all others compile it anew.
const live_fields = ['gravity', 'solver'];
const live_material = ['edge_stiffness', 'diagonal_stiffness', 'damping'];

/// Making the simulation from the scene and the model, and driving it.
export const playing = app => {
  const {store, simulation, playback, meshing} = app;

  /// The simulation stands for the present model and scene, or is made anew.
  const ensure = async () => {
    const wanted = {scene: frozen(store.get('scene')), model: meshing.model?.id};
    if (simulation.state === 'recording' || simulation.state === 'reading') return;
    if (simulation.id && same(wanted, app.compiled)) return;
    if (!meshing.model || meshing.preview) await model_ready(meshing);
    app.compiled = {scene: frozen(store.get('scene')), model: meshing.model.id};
    app.sent = structuredClone(store.get('scene'));
    await simulation.create(wire_scene(store.get('scene'), meshing.model.id));
  };

  const show_simulation = () => {
    if (store.get('view.layers.sim')) return;
    store.set({'view.layers': {surface: false, voxels: false, tets: false, sim: true}}, 'show the simulation');
  };

  const started = action => app.run(async () => {
    show_simulation();
    await ensure();
    await action();
  });

  const patch_live = () => app.run(async () => {
    if (!simulation.id || !app.sent) return;
    const changes = live_changes(app.sent, store.get('scene'));
    app.sent = structuredClone(store.get('scene'));
    if (Object.keys(changes).length) await simulation.patch(changes);
  });
  store.on('scene', () => !app.restoring && patch_live());

  return {
    toggle_play: () => playback.playing ? app.run(() => playback.pause()) : started(() => playback.play()),
    step: frames => started(() => playback.step(frames)),
    restart: () => started(() => playback.restart(playback.playing)),
    replay: file => app.run(async () => {
      store.set({'view.layers': {surface: false, voxels: false, tets: false, sim: true}}, 'show the recording');
      app.compiled = null;
      await simulation.replay(file);
    }),
    toggle_recording: () => app.run(async () => {
      if (!simulation.recording) return simulation.start_recording();
      const file = await simulation.stop_recording();
      download(file, `${store.get('scene').name}.ndjson`);
      app.say('Recording saved; drop it on the page to play it back');
    }),
  };
};

function model_ready(meshing) {
  return new Promise((resolve, reject) => {
    const check = () => !meshing.preview && meshing.model && done(resolve);
    const fail = () => done(() => reject(meshing.problem));
    const done = end => {
      meshing.removeEventListener('model', check);
      meshing.removeEventListener('problem', fail);
      end();
    };
    meshing.addEventListener('model', check);
    meshing.addEventListener('problem', fail);
    if (meshing.preview) meshing.request(false);
  });
}

/// The scene without what can change while it runs.
function frozen(scene) {
  const rest = {...scene, bodies: scene.bodies.map(body => ({...body}))};
  for (const name of live_fields) delete rest[name];
  for (const body of rest.bodies) for (const name of live_material) delete body[name];
  return rest;
}

function live_changes(before, now) {
  const changes = {};
  for (const name of live_fields) if (!same(before[name], now[name])) changes[name] = now[name];
  const materials = now.bodies.map((body, index) => ({body, index})).filter(({body, index}) =>
    live_material.some(name => body[name] !== before.bodies[index]?.[name]));
  if (materials.length) changes.materials = materials.map(({body, index}) =>
    ({body: index, ...Object.fromEntries(live_material.map(name => [name, body[name]]))}));
  return changes;
}
