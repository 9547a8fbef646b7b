/// What tets and voxels can be coloured by: title, unit and scale.
export const tet_scales = {
  min_dihedral_deg: {title: 'Dihedral angle', unit: '°', map: 'sequential', min: 0, max: 70.5},
  scaled_jacobian: {title: 'Scaled Jacobian', unit: '', map: 'sequential', min: 0, max: 1},
  density: {title: 'Density', unit: '', map: 'sequential', min: 0, max: 1},
  volume_error: {title: 'Volume error', unit: '', map: 'error', min: -9, max: -1, logarithmic: true},
  none: {title: 'No colour', unit: '', map: 'sequential', min: 0, max: 1, plain: true},
};

export const voxel_scales = {
  none: {title: 'No colour', plain: true},
  probability: {title: 'P', map: 'sequential', min: 0, max: 1},
  votes: {title: 'Votes', map: 'sequential', min: 0, max: 26},
  density: {title: 'Density of the cell', map: 'sequential', min: 0, max: 1},
};

/// {nouns, title, unit, scale, values}: values a number a tet, null where there is nothing to colour by.
export function tet_coloring(name, {cells, voxels}, sim) {
  const scale = tet_scales[name];
  const values = scale.plain || !cells ? null : values_of(name, cells, voxels, sim);
  return {nouns: 'tets', title: scale.title, unit: scale.unit, scale: values ? scale : null, values};
}

/// Of the simulation's cells: their errors in the frame shown, or what the model's tets have at rest.
export function sim_coloring(name, model, sim) {
  const bodies = sim.views().filter(({body}) => body.type === 'deformable');
  if (name === 'volume_error') {
    const scale = bodies.length ? tet_scales.volume_error : null;
    return {...model, scale, values: scale && joined(bodies.map(view => view.errors_per_tet()))};
  }
  const known = model.values && bodies.some(view => view.has_tets_of(model.values));
  return known ? {...model, title: `${model.title} at rest`} : {...model, scale: null, values: null};
}

function joined(arrays) {
  if (arrays.length === 1) return arrays[0];
  const all = new Float32Array(arrays.reduce((sum, {length}) => sum + length, 0));
  arrays.reduce((from, array) => (all.set(array, from), from + array.length), 0);
  return all;
}

function values_of(name, cells, voxels, sim) {
  if (name === 'density') return voxels ? density_values(cells, voxels.lattice) : null;
  if (name !== 'volume_error') return cells[name];
  const body = sim.views().find(view => view.has_tets_of?.(cells.min_dihedral_deg));
  return body ? body.errors_per_tet() : null;
}

function density_values(cells, {grid, density}) {
  const [nx, ny] = grid.size;
  const values = new Float32Array(cells.tets.length / 4);
  for (let tet = 0; tet < values.length; ++tet) {
    const [i, j, k] = cells.cells.subarray(3 * Math.floor(tet / 5), 3 * Math.floor(tet / 5) + 3);
    values[tet] = density[i + nx * (j + ny * k)];
  }
  return values;
}

export function voxel_coloring(name, voxels) {
  const scale = name === 'votes' ? {...voxel_scales.votes, min: Math.floor(voxels.rays / 2), max: voxels.rays} : voxel_scales[name];
  const values = scale.plain ? null : name === 'density' ? voxel_densities(voxels) : voxels[name];
  return {nouns: 'voxels', title: scale.title, unit: '', scale: values ? scale : null, values};
}

function voxel_densities({grid, index, lattice}) {
  const [nx, ny] = grid.size;
  return Float32Array.from(index, at => {
    const coord = [at % nx, Math.floor(at / nx) % ny, Math.floor(at / (nx * ny))];
    const cell = coord.map((i, axis) => Math.floor((grid.origin[axis] + (i + 0.5) * grid.spacing - lattice.grid.origin[axis]) / lattice.grid.spacing));
    const inside = cell.every((i, axis) => i >= 0 && i < lattice.grid.size[axis]);
    return inside ? lattice.density[cell[0] + lattice.grid.size[0] * (cell[1] + lattice.grid.size[1] * cell[2])] : 0;
  });
}

/// Position of a value on the scale, 0 to 1 (beyond it outside).
export function along(scale, value) {
  const at = scale.logarithmic ? Math.log10(Math.max(value, 1e-30)) : value;
  return (at - scale.min) / (scale.max - scale.min);
}

/// A byte for each `group` of values (the five tets of a cell, one voxel): some of them lie in the range {from, to} of the
/// scale (0 to 1); null when all are shown.
export function make_selection(range, {values, scale}, group) {
  if (!range || !values) return null;
  const selected = new Uint8Array(Math.floor(values.length / group));
  for (let k = 0; k < values.length; ++k) {
    const at = Math.min(0.99999, Math.max(0, along(scale, values[k])));
    if (at >= range.from && at < range.to) selected[Math.floor(k / group)] = 1;
  }
  return selected;
}

export function histogram(values, scale, bins) {
  const counts = new Uint32Array(bins);
  for (const value of values) ++counts[Math.min(bins - 1, Math.max(0, Math.floor(bins * along(scale, value))))];
  return counts;
}
