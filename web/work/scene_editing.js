import {only_sim} from './playing.js';
import {complete_scene, own_scene} from '../state/scene_templates.js';

const free_name = (bodies, kind) => {
  for (let n = 1; ; ++n) if (!bodies.some(({name}) => name === `${kind} ${n}`)) return `${kind} ${n}`;
};

const size = 0.2, gap = 0.05;  // metres

/// The box of the bodies, as wide as it becomes when a start bends or twists one.
function start_bounds({looking: {bodies_bounds: bounds}, store}) {
  if (!store.get('scene').bodies.some(({start}) => start)) return bounds;
  const {min, max} = bounds.clone();
  const middle = (min.x + max.x) / 2, reach = Math.hypot(max.x - min.x, max.z - min.z) / 2;
  return {min: {...min, x: middle - reach}, max: {...max, x: middle + reach}};
}

/// Beside or below what is there already, so that nothing starts inside a body.
const new_shapes = {
  sphere: ({min, max}) => ({shape: {sphere: {radius: size}}, position: beside(max.x + gap + size, min.y)}),
  box: ({min}) => ({shape: {box: {half_extents: [size, size, size]}}, position: beside(min.x - gap - size, min.y)}),
  plane: ({min}) => ({shape: {plane: {normal: [0, 1, 0], offset: round(min.y - gap)}}}),
};

const round = x => Number(x.toFixed(3));
const beside = (x, floor) => [round(x), round(floor + size), 0];

/// Colliders of the scene, and scenes that come with the samples or from files.
export const scene_editing = app => {
  const {store} = app;
  const bodies = () => store.get('scene').bodies;
  return {
    add_collider(kind) {
      const body = {name: free_name(bodies(), kind), type: 'rigid', ...new_shapes[kind](start_bounds(app)), static: true};
      store.set({'scene.bodies': [...bodies(), body]}, `add ${body.name}`);
      app.select_collider(bodies().length - 1);
      app.say(`${body.name} added`);
    },
    remove_collider(index) {
      const {name} = bodies()[index];
      store.set({'scene.bodies': bodies().filter((_, k) => k !== index)}, `remove ${name}`);
      app.say(`${name} removed`);
    },
    select_collider(index) {
      app.selected_collider = index;
      app.tell('collider', index);
    },
    open_scene: sample => app.run(async () => app.open_scene_document(await app.client.get(sample.url))),
    /// A scene as a file has it. What was there stays until all its meshes are found.
    async open_scene_document(scene) {
      await app.find_meshes(scene);
      store.set({scene: complete_scene(scene), template: own_scene, 'view.layers': only_sim, 'view.camera': null}, `scene ${scene.name}`);
      app.tell('scene');
      await app.ready_to_step();
    },
  };
};
