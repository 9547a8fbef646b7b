import {make_scene, wire_scene} from '../state/scene_templates.js';
import {difference} from '../state/scene_changes.js';
import {same} from '../state/store.js';
import {download} from '../ui/dom.js';

export const only_sim = {surface: false, voxels: false, tets: false, sim: true};

/// Making the simulation from the scene and the model, driving it, and taking changes of the scene while it runs.
export const playing = app => {
  const {store, simulation, playback, meshing} = app;

  let compiling = null;

  /// continuing: bodies keep their motion.
  const compile = (continuing = false) => compiling = compile_now(continuing);
  const compile_now = async continuing => {
    await meshing.whole_model();
    const scene = structuredClone(store.get('scene'));
    await app.find_meshes(scene);
    app.compiled = {scene, model: meshing.model.id};
    app.running = structuredClone(scene);
    await simulation.create(wire_scene(scene, meshing.model.id, app.mesh_of_file), continuing);
    simulation.speed = store.get('speed');
    if (simulation.speed !== 1) await simulation.patch({speed: simulation.speed});
    if (simulation.id) await take_changes(false);  // made meanwhile
  };

  const stale = () => !simulation.id || app.compiled?.model !== meshing.model?.id || difference(app.running, store.get('scene')).structural;
  const is_recording = () => simulation.state === 'recording' || simulation.state === 'reading';

  let getting_ready = null;
  const ready_to_step = () => getting_ready ??= get_ready().finally(() => getting_ready = null);
  const get_ready = async () => {
    await compiling?.catch(() => {});
    if (!is_recording() && stale()) await compile();
  };
  /// Shows the run as well, once it is there: for what a person does with it.
  const ready_and_shown = async () => {
    await ready_to_step();
    if (!store.get('view.layers.sim')) store.set({'view.layers': only_sim}, 'show the simulation');
  };

  const recompile = (continuing = false) => playback.playing || playback.starting ? start(() => compile(continuing)) : compile(continuing);

  /// Plays once it is ready, unless that was taken back meanwhile.
  const start = async make_ready => {
    playback.set_starting(true);
    try {
      await make_ready();
      if (playback.starting && !playback.playing) await playback.play();
    } finally {
      playback.set_starting(false);
    }
  };

  const restart_with_changes = async () => {
    await recompile();
    app.say('The run started again with what has changed');
  };

  const take_changes = live => app.run(async () => {
    if (!simulation.id || !app.running) return;
    const scene = store.get('scene');
    const {patch, moves, structural, restarts} = difference(app.running, scene);
    if (structural && live) return null;
    if (structural && restarts && !store.get('view.layers.sim')) return simulation.forget();
    if (structural) return restarts ? restart_with_changes() : recompile(true);
    app.running = structuredClone(scene);
    if (Object.keys(patch).length) await simulation.patch(patch);
    for (const {body, ...pose} of moves) await app.client.send('PUT', `/simulations/${simulation.id}/colliders/${body}`, pose);
  });

  store.on('scene', live => !app.restoring && meshing.shows(store.get('mesh')) && take_changes(live));
  /// Its layer shows the start of a run that has not been played.
  store.on('view.layers', () => {
    const nothing_yet = simulation.state === 'none' && !simulation.bodies.length && meshing.model && !getting_ready && !app.restoring;
    if (nothing_yet && store.get('view.layers.sim')) app.run(ready_to_step);
  });
  store.on('speed', () => app.run(() => playback.set_speed(store.get('speed'))));
  meshing.addEventListener('model', () => {
    if (simulation.id && !meshing.preview && store.get('view.layers.sim')) app.run(() => recompile());
  });

  return {
    ready_to_step,
    ready_and_shown,
    toggle_play: () => app.run(async () => {
      if (playback.starting) return playback.set_starting(false);
      if (playback.playing) return playback.pause();
      await start(ready_and_shown);
    }),
    step: frames => app.run(async () => {
      if (playback.starting) playback.set_starting(false);
      await ready_and_shown();
      await playback.step(frames);
    }),
    end_run: () => app.run(async () => {
      await simulation.close();
      simulation.set_state('none');
      app.say('The run was ended; play starts it anew');
    }),
    /// When the server no longer has it.
    start_again: () => app.run(() => start(compile)),
    /// From the start as the scene now says.
    restart: () => app.run(async () => {
      if (!is_recording() && simulation.id && !same(app.compiled.scene, store.get('scene'))) return recompile();
      await ready_and_shown();
      await playback.restart(playback.playing);
    }),
    go_to_frame: seq => app.run(async () => {
      await ready_to_step();
      for (let at = simulation.shown?.seq ?? 0; at < seq; at += 60)
        await app.client.send('POST', `/simulations/${simulation.id}/steps`, {count: Math.min(60, seq - at)});
    }),
    replay: file => app.run(async () => {
      app.compiled = null;
      if (await simulation.replay(file)) store.set({'view.layers': only_sim}, 'show the recording');
    }),
    /// Back to the scene.
    close_recording() {
      simulation.forget();
      app.say('Recording closed');
      return store.get('view.layers.sim') && app.run(ready_to_step);
    },
    toggle_recording: () => app.run(async () => {
      if (!simulation.recording) {
        await ready_and_shown();
        simulation.start_recording();
        return app.say('Recording: R again ends it and saves the file');
      }
      download(await simulation.stop_recording(), `${store.get('scene').name}.ndjson`);
      app.say('Recording saved; drop it on the page to play it back');
    }),
    fit_scene() {
      app.template_scene = make_scene(store.get('template'), meshing.mesh.report.bounds, store.get('mesh'));
      return structuredClone(app.template_scene);
    },
  };
};
