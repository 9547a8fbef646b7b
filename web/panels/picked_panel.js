import {h} from '../ui/dom.js';
import {number} from '../ui/format.js';
import {cell_volumes} from '../view/deformation.js';
import {ray_plot} from './ray_plot.js';

/// The values of what was picked, and P along the ray through it.
export function picked_panel(app) {
  const {events, meshing} = app;
  const facts = h('dl', {class: 'facts'});
  const hint = h('p', {class: 'quiet'}, 'Click a cell or a voxel in the view, or press P for what stands in its middle.');
  const plot = h('div');
  const clear = () => {
    facts.replaceChildren();
    plot.replaceChildren();
    hint.hidden = false;
  };
  events.addEventListener('picked', ({detail}) => {
    clear();
    if (!detail) return;
    hint.hidden = true;
    facts.replaceChildren(...rows(detail, meshing).flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
  });
  events.addEventListener('ray', ({detail}) => plot.replaceChildren(ray_plot(detail)));
  meshing.addEventListener('mesh', () => app.clear_pick());  // of another one, which may stay without a model
  meshing.addEventListener('model', clear);
  return [hint, facts, plot];
}

function rows({kind, cell, tet, voxel, triangle}, {cells, voxels}) {
  if (kind === 'triangle') return [['Triangle', String(triangle)]];
  if (kind === 'voxel') return [['P', number(voxels.probability[voxel], 4)], ['Votes inside', `${voxels.votes[voxel]} of ${voxels.rays}`]];
  const coord = cells.cells ? [...cells.cells.subarray(3 * cell, 3 * cell + 3)].join(', ') : '–';
  return [['Cell', `${cell} (${coord})`], ['Tet', String(tet)], ['Dihedral angle', `${number(cells.min_dihedral_deg[tet])}°`],
    ['Scaled Jacobian', number(cells.scaled_jacobian[tet])], ['Volume', number(cell_volumes(cells.positions, cells.tets.subarray(20 * cell, 20 * cell + 20))[0], 4)]];
}

