const free_name = (bodies, kind) => {
  for (let n = 1; ; ++n) if (!bodies.some(({name}) => name === `${kind} ${n}`)) return `${kind} ${n}`;
};

const new_shapes = {
  sphere: {shape: {sphere: {radius: 0.2}}, position: [0.4, 0.2, 0]},
  box: {shape: {box: {half_extents: [0.2, 0.2, 0.2]}}, position: [-0.4, 0.2, 0]},
  plane: {shape: {plane: {normal: [0, 1, 0], offset: -0.5}}},
};

/// Colliders of the scene, and scenes that come with the samples or from files.
export const scene_editing = app => {
  const {store} = app;
  const bodies = () => store.get('scene').bodies;
  return {
    add_collider(kind) {
      const body = {name: free_name(bodies(), kind), type: 'rigid', ...structuredClone(new_shapes[kind]), static: true};
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
    /// A scene as a file has it: its first mesh of the samples becomes the model that the page shows.
    async open_scene_document(scene) {
      store.set({scene}, `scene ${scene.name}`);
      app.tell('scene');
      await app.ready_to_step();
    },
  };
};
