import {exploded, indexed, raycast} from '../view/raycast.js';
import {tet_of_face} from '../view/cell_topology.js';
import {plane_in} from '../view/clip_plane.js';
import * as THREE from 'three';

const click_slack = 4;  // pixels that a click may move

/// What a person points at: a cell and its tet, a voxel (and P along its ray), a body of the simulation.
export const picking = app => {
  const {viewport, store, looking, meshing} = app;
  let press = null;
  viewport.canvas.addEventListener('pointerdown', event => press = {x: event.clientX, y: event.clientY});
  viewport.canvas.addEventListener('pointerup', event => {
    const still = press && Math.hypot(event.clientX - press.x, event.clientY - press.y) < click_slack;
    press = null;
    if (still && event.button === 0 && !app.grabbed_by_pointer) pick(viewport.ray(event));
  });

  const pick = ray => {
    const hit = nearest(app, ray);
    app.picked = hit;
    looking.mark_picked(hit);
    app.tell('picked', hit);
    if (hit) app.say(hit.says);
    if (hit?.point_in_model && meshing.model) app.run(() => show_ray(app, hit, ray));
  };

  return {
    pick_middle() {
      const box = viewport.canvas.getBoundingClientRect();
      pick(viewport.ray({clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));
    },
    clear_pick: () => pick_nothing(app),
    pick_sim: (ray, layers = store.get('view.layers')) => layers.sim ? nearest_body(app, ray) : null,
  };
};

function pick_nothing(app) {
  app.picked = null;
  app.looking.mark_picked(null);
  app.tell('picked', null);
}

function nearest(app, ray) {
  const {store, looking} = app;
  const layers = store.get('view.layers');
  const local = ray_in_model(app, ray);
  const candidates = [];
  const plane = looking.plane ? plane_in(looking.plane, app.viewport.model.matrix) : null;
  if (layers.tets && app.meshing.cells) candidates.push(pick_cell(app, local, store.get('view.clip.mode') === 'cut' ? plane : null));
  if (layers.voxels && app.meshing.voxels) candidates.push(pick_voxel(app, local));
  if (layers.surface && app.meshing.geometry) candidates.push(pick_surface(app, local));
  return candidates.filter(Boolean).sort((a, b) => a.distance - b.distance)[0] ?? null;
}

/// Distances stay those of the world's ray, up to the placement's scale.
function ray_in_model({viewport}, ray) {
  const inverse = viewport.model.matrix.clone().invert();
  return ray.clone().applyMatrix4(inverse);
}

function pick_cell({looking, meshing}, ray, plane) {
  const {faces, cut, centers} = looking.tets;
  const hits = [[faces, plane], [cut, null]].map(([list, clip]) => ({list, hit: raycast(exploded(list, centers.middle), ray, clip)})).filter(({hit}) => hit);
  if (!hits.length) return null;
  const {list, hit} = hits.sort((a, b) => a.hit.distance - b.hit.distance)[0];
  const tet = list === faces ? tet_of_face(faces.faces[hit.triangle]) : cut.tets[Math.floor(hit.triangle / 2)];
  const cell = Math.floor(tet / 5);
  return {kind: 'cell', cell, tet, distance: hit.distance, point_in_model: hit.point,
    says: `Cell ${cell}, tet ${tet}: smallest dihedral angle ${meshing.cells.min_dihedral_deg[tet].toFixed(1)}°`};
}

function pick_voxel({looking, meshing}, ray) {
  const hit = raycast(looking.voxels.list, ray);
  if (!hit) return null;
  const voxel = looking.voxels.shown_voxels[Math.floor(hit.triangle / 2)];
  const {probability, votes, rays} = meshing.voxels;
  return {kind: 'voxel', voxel, distance: hit.distance, point_in_model: looking.voxels.center(voxel),
    says: `Voxel: P ${probability[voxel].toFixed(3)}, ${votes[voxel]} of ${rays} votes`};
}

function pick_surface({looking}, ray) {
  const hit = raycast(indexed(looking.surface), ray);
  return hit && {kind: 'triangle', triangle: hit.triangle, distance: hit.distance, point_in_model: hit.point, says: `Triangle ${hit.triangle}`};
}

/// A body of the simulation: for deformable ones the vertex nearest to the hit.
function nearest_body({looking}, ray) {
  let best = null;
  for (const view of looking.sim.views()) {
    const hit = view.raycast(ray);
    if (hit && (!best || hit.distance < best.distance)) best = {...hit, view, body: view.body};
  }
  return best;
}

/// P along the lattice direction nearest to the line of sight, through the picked point.
async function show_ray(app, {point_in_model}, ray) {
  const direction = new THREE.Vector3().copy(ray.direction).transformDirection(app.viewport.model.matrix.clone().invert());
  const largest = Math.max(Math.abs(direction.x), Math.abs(direction.y), Math.abs(direction.z));
  const lattice = direction.toArray().map(x => Math.round(x / largest));
  const {model, origin} = app.meshing, point = point_in_model.map((x, axis) => x + origin[axis]);
  const path = `/models/${model.id}/ray?point=${point.join()}&direction=${lattice.join()}`;
  app.ray = await app.load(path);
  app.looking.show_ray(app.ray);
  app.tell('ray', app.ray);
}
