/// Changes that other parameters need so that the set stays valid: P_subs at least as far as P_in, two voxels a cell.
export function settle(params, changes) {
  const next = {...params, ...changes};
  const more = {};
  if (next.p_subs_voxels < next.p_in_voxels) {
    if ('p_subs_voxels' in changes) more.p_in_voxels = next.p_subs_voxels;
    else more.p_subs_voxels = next.p_in_voxels;
  }
  if (next.p_in !== null && next.p_subs !== null && next.p_subs > next.p_in) {
    if ('p_subs' in changes) more.p_in = next.p_subs;
    else more.p_subs = next.p_in;
  }
  if (2 * next.cells > next.voxels) {
    if ('voxels' in changes) more.cells = Math.floor(next.voxels / 2);
    else more.voxels = Math.min(512, 8 * Math.ceil(next.cells / 4));
  }
  return {...changes, ...more};
}

/// {name: value} as changes of the state.
export const param_changes = values =>
  Object.fromEntries(Object.entries(values).map(([name, value]) => [`params.${name}`, value]));
