import {h, svg} from '../ui/dom.js';
import {number} from '../ui/format.js';

const width = 264, height = 120, left = 36, bottom = 18, top = 6;

/// P along a ray with both thresholds, the part that was judged inside, and the picked voxel: P above P_in while it
/// rises changes sides; only after P fell under P_subs may it change again. The thresholds stand in the upper half: far
/// lower P lies along the bottom.
export function ray_plot({probability, inside, thresholds, picked, positions}) {
  const last = Math.max(1, probability.length - 1);
  const lowest = Math.min(thresholds.p_subs, ...probability);
  const low = Math.max(0, lowest - 0.1 * (1 - lowest), 1 - 3 * (1 - thresholds.p_subs));
  const x = k => left + (width - left) * k / last;
  const y = p => top + (height - top - bottom) * (1 - Math.max(p, low)) / (1 - low);
  const line = Array.from(probability, (p, k) => `${k ? 'L' : 'M'}${x(k).toFixed(1)} ${y(p).toFixed(1)}`).join('');
  const length = Math.hypot(...[0, 1, 2].map(axis => positions[positions.length - 3 + axis] - positions[axis]));
  const threshold = (p, name) => [
    svg('line', {x1: left, x2: width, y1: y(p), y2: y(p), class: `threshold ${name}`}),
    svg('text', {x: width - 2, y: y(p) + (name === 'in' ? -3 : 10), 'text-anchor': 'end'}, `P_${name} ${number(p, 4)}`)];
  return h('figure', {class: 'ray-plot'}, h('figcaption', {}, 'P along the picked ray'),
    svg('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': describe(probability, inside, thresholds)},
      inside_bands(inside, x), ...threshold(thresholds.p_in, 'in'), ...threshold(thresholds.p_subs, 'subs'),
      svg('path', {d: line, class: 'curve'}),
      picked >= 0 ? svg('circle', {cx: x(picked), cy: y(probability[picked]), r: 3.5, class: 'picked'}) : [],
      ...[low, 1].map(p => svg('text', {x: left - 4, y: y(p) + 4, 'text-anchor': 'end'}, `${p > lowest && p < 1 ? '≤ ' : ''}${number(p, 2)}`)),
      svg('text', {x: left, y: height - 4}, '0'), svg('text', {x: width, y: height - 4, 'text-anchor': 'end'}, `${number(length)} units`)),
    h('p', {class: 'quiet'}, 'Shaded: judged inside. A ray takes note of the surface above P_in, and is armed again under P_subs.'));
}

function inside_bands(inside, x) {
  const bands = [];
  for (let k = 0; k < inside.length; ++k) {
    if (!inside[k] || (k && inside[k - 1])) continue;
    let end = k;
    while (end + 1 < inside.length && inside[end + 1]) ++end;
    bands.push(svg('rect', {x: x(k - 0.5), y: top, width: x(end + 0.5) - x(k - 0.5), height: height - top - bottom, class: 'inside'}));
  }
  return bands;
}

function describe(probability, inside, {p_in, p_subs}) {
  const crossings = inside.reduce((sum, value, k) => sum + (k > 0 && value !== inside[k - 1] ? 1 : 0), 0);
  return `P along the ray through ${probability.length} voxels, largest ${number(Math.max(...probability))}; P_in ${number(p_in)}, P_subs ${number(p_subs)}; ${crossings} changes between inside and outside`;
}
