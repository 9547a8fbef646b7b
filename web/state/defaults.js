/// What a first visitor sees: the sample tree, its tets half open.
export const default_state = {
  mesh: {sample: 'tree', id: null, name: 'tree', up: 'y', fit: true, unit: 1},
  params: {},
  template: 'sway',
  scene: null,
  speed: 1,
  frame: null,
  view: {
    layers: {surface: true, voxels: false, tets: true, sim: false},
    clip: {on: true, axis: 'z', position: 0.5, flip: false, mode: 'whole', normal: [0.7, 0.2, 0.7]},
    explode: 0, edges_only: false, color_by: 'min_dihedral_deg', voxel_color: 'none', select: null, sim_look: 'skin', surface_look: 'solid',
    orthographic: false, camera: null,
  },
};
