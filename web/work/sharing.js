import {decode_link, encode_link, merge} from '../state/link.js';
import {default_state} from '../state/defaults.js';
import {wire_params} from './meshing.js';
import {download} from '../ui/dom.js';

/// The state in the address, so that a copied link shows the same, and the settings as a file.
const base_params = (app, {sample}) => sample ? app.sample_params(sample) : app.defaults;

export const sharing = app => {
  const {store, simulation} = app;
  let timer = 0;
  const write = () => {
    const {shown} = simulation;
    const frame = store.get('view.layers.sim') && shown?.seq && simulation.state !== 'playing' ? shown.seq : null;
    const hash = encode_link({...store.state, frame}, {params: base_params(app, store.get('mesh')), scene: app.template_scene ?? store.get('scene')});
    if (hash !== location.hash) globalThis.history.replaceState(null, '', hash || location.pathname);
  };
  const soon = () => {
    clearTimeout(timer);
    timer = setTimeout(write, 300);
  };
  store.addEventListener('change', soon);
  for (const name of ['frame', 'state']) simulation.addEventListener(name, soon);
  addEventListener('hashchange', () => app.restore(location.hash));

  return {
    write_link: write,
    async share() {
      write();
      const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
      app.say(`${copied ? 'Link copied' : 'The link stands in the address bar'}: it holds the parameters, the camera, the clip and the frame`);
    },
    /// Opens what a link describes; false when there is no link.
    async restore(hash) {
      const difference = decode_link(hash);
      if (!difference) return false;
      const {frame, ...state} = merge({...default_state, params: base_params(app, {...default_state.mesh, ...difference.mesh})}, difference);
      app.restoring = true;
      store.adopt({...state, scene: null});  // what a link says of it is told of the template's, which the mesh gives
      app.restoring = false;
      const {sample, id} = state.mesh;
      await app.open(sample ? {sample} : {id});
      if (difference.scene) store.adopt({scene: merge(app.template_scene, difference.scene)});
      app.tell('scene');
      if (frame) await app.go_to_frame(frame);
      else if (store.get('view.layers.sim')) await app.run(app.ready_to_step);
      return true;
    },
    save_params() {
      const text = `${JSON.stringify(wire_params(store.get('params')), null, 2)}\n`;
      download(new Blob([text], {type: 'application/json'}), `${app.stem()}.params.json`);
      app.say(`Settings saved: isochor mesh FILE -o OUT.msh --params ${app.stem()}.params.json`);
    },
    save_scene() {
      const scene = {...store.get('scene'), bodies: store.get('scene').bodies.map(body => body.mesh === 'current'
        ? {...body, mesh: app.meshing.mesh.name, meshing: wire_params(store.get('params'))} : body)};
      download(new Blob([`${JSON.stringify(scene, null, 2)}\n`], {type: 'application/json'}), `${scene.name}.json`);
      app.say('Scene saved: put it beside the mesh and run isochor simulate');
    },
  };
};
