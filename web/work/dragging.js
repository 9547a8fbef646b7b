import * as THREE from 'three';

const key_step = 0.03;  // metres a key press

/// Dragging the body and the colliders in a running simulation, by pointer or by keys; the newest target wins.
export const dragging = app => {
  const {viewport, simulation, store} = app;
  const {canvas} = viewport;
  let drag = null;
  const sender = newest_wins(app);

  canvas.addEventListener('pointerdown', event => {
    if (drag?.pointer !== undefined) return give_to_camera();  // a second finger: both move the camera
    if (event.button !== 0 || event.altKey || event.shiftKey || !simulation.id || drag) return;
    const hit = app.pick_sim(viewport.ray(event));
    if (!hit || hit.body.shape?.plane) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    begin(hit);
    app.grabbed_by_pointer = true;
    Object.assign(drag, {pointer: event.pointerId, last: event});
    canvas.style.cursor = 'grabbing';
  }, {capture: true});
  canvas.addEventListener('pointermove', event => {
    if (!drag) return void hover(app, event);
    if (event.pointerId !== drag.pointer) return;
    drag.last = event;
    const point = viewport.ray(event).intersectPlane(drag.plane, new THREE.Vector3());
    if (point) move_to(point);
  });
  for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, event => {
    setTimeout(() => app.grabbed_by_pointer = false);
    if (drag && event.pointerId === drag.pointer) release();
  });

  const begin = hit => {
    const at = new THREE.Vector3(...hit.point);
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(viewport.camera.getWorldDirection(new THREE.Vector3()), at);
    drag = {...hit, plane, start: at.clone(), target: at, run: simulation.id};
    if (hit.vertex !== undefined) {
      viewport.mark(at.toArray(), 0.03 * viewport.radius());
      if (simulation.state === 'paused' && !app.playback.starting) drag.started = app.toggle_play();
      sender.send('PUT', {body: hit.body.id, vertex: hit.vertex, target: at.toArray()});
    } else {
      drag.pose = hit.view.pose;
      app.select_collider(hit.body.id);
    }
  };
  const move_to = point => {
    if (drag.run !== simulation.id) return release();
    drag.target = point.clone();
    if (drag.vertex !== undefined) {
      viewport.mark(point.toArray(), 0.03 * viewport.radius());
      sender.send('PUT', {body: drag.body.id, vertex: drag.vertex, target: point.toArray()});
    } else {
      const position = drag.pose.slice(0, 3).map((x, axis) => Number((x + point.getComponent(axis) - drag.start.getComponent(axis)).toFixed(4)));
      store.preview({[`scene.bodies.${drag.body.id}.position`]: position}, `move ${drag.body.name}`);
    }
  };
  const give_to_camera = () => {
    const {last, started} = drag;
    release();
    started?.then(() => app.playback.playing && app.toggle_play());  // unless it was paused meanwhile
    viewport.controls.take(last);
  };
  const release = () => {
    if (drag.vertex === undefined) store.commit();
    else if (drag.run === simulation.id) sender.send('DELETE');
    viewport.mark(null);
    drag = null;
    canvas.style.cursor = '';
  };
  simulation.addEventListener('bodies', () => drag && release());  // another run, which has not been grabbed

  return {
    grab_middle: () => app.run(async () => {
      if (drag) return release();
      await app.ready_and_shown();
      if (!simulation.id) return app.say('A recording cannot be dragged: close it to go back to the scene');
      const box = canvas.getBoundingClientRect();
      const aimed = app.pick_sim(viewport.ray({clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}), {sim: true});
      const hit = aimed && !aimed.body.shape?.plane ? aimed : top_vertex(app);
      if (!hit) return app.say('There is no body to grab');
      begin(hit);
      drag.by_keys = true;
      await drag.started;  // which says so in the same line
      if (!drag) return;
      app.say(`Grabbed ${hit.body.name}: arrows and Page Up or Down pull, Escape lets go`);
    }),
    /// Whether the key moved what is grabbed.
    grab_key({key}) {
      if (!drag?.by_keys) return false;
      const right = new THREE.Vector3().setFromMatrixColumn(viewport.camera.matrixWorld, 0);
      const up = new THREE.Vector3().setFromMatrixColumn(viewport.camera.matrixWorld, 1);
      const toward = new THREE.Vector3().setFromMatrixColumn(viewport.camera.matrixWorld, 2);
      const move = {ArrowLeft: [right, -1], ArrowRight: [right, 1], ArrowUp: [up, 1], ArrowDown: [up, -1], PageUp: [toward, 1], PageDown: [toward, -1]}[key];
      if (!move) return false;
      move_to(drag.target.clone().addScaledVector(move[0], move[1] * key_step));
      return true;
    },
    let_go() {
      if (!drag) return false;
      release();
      app.say('Let go');
      return true;
    },
  };
};

/// Where nothing stands in the middle: the highest particle of the first deformable body.
function top_vertex({looking}) {
  const view = looking.sim.views().find(({body}) => body.type === 'deformable');
  if (!view) return null;
  let vertex = 0;
  for (let v = 0; v < view.positions.length / 3; ++v) if (view.positions[3 * v + 1] > view.positions[3 * vertex + 1]) vertex = v;
  return {view, body: view.body, vertex, point: [...view.positions.subarray(3 * vertex, 3 * vertex + 3)]};
}

function hover({viewport, simulation, store, pick_sim}, event) {
  const over = event.buttons === 0 && simulation.id && store.get('view.layers.sim') && pick_sim(viewport.ray(event));
  viewport.canvas.style.cursor = over && !over.body.shape?.plane ? 'grab' : '';
}

/// One request on its way; of those that wait only the newest is sent, to the run that there is then.
function newest_wins(app) {
  let busy = false, next = null;
  const pump = async () => {
    busy = true;
    while (next) {
      const [method, json] = next, {id} = app.simulation;
      next = null;
      if (id) await app.run(() => app.client.send(method, `/simulations/${id}/grabs/1`, json));
    }
    busy = false;
  };
  return {
    send(...request) {
      next = request;
      if (!busy) pump();
    },
  };
}
