import {change_text, h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {number} from '../ui/format.js';
import {calmly} from './calmly.js';

/// Both forms of the thresholds, and the switch between them.
export function threshold_note({store, meshing}) {
  const table = h('dl', {class: 'facts'});
  const change = button('', () => store.set(switched(store.get('params'), meshing.model?.thresholds), 'form of the thresholds'), {class: 'plain'});
  const show_form = () => change_text(change, `Set thresholds as ${store.get('params.p_in') !== null ? 'distances' : 'probabilities'}`);
  const show = () => {
    const t = meshing.model?.thresholds;
    table.replaceChildren(...t ? [
      h('dt', {}, 'P_in'), h('dd', {}, `P ${number(t.p_in, 4)} · ${number(t.d_in)} units`),
      h('dt', {}, 'P_subs'), h('dd', {}, `P ${number(t.p_subs, 4)} · ${number(t.d_subs)} units`)] : []);
  };
  meshing.addEventListener('mesh', show);
  meshing.addEventListener('model', calmly(meshing, show));
  store.on('params', show_form);
  show_form();
  return h('div', {class: 'note'}, table, change);
}

function switched(params, thresholds) {
  const t = thresholds ?? {p_in: 0.95, p_subs: 0.92, p_in_voxels: 1, p_subs_voxels: 1.5};
  const clean = x => Number(x.toPrecision(4));
  if (params.p_in === null) return {'params.p_in': clean(t.p_in), 'params.p_subs': clean(t.p_subs)};
  return {'params.p_in': null, 'params.p_subs': null, 'params.p_in_voxels': clean(t.p_in_voxels), 'params.p_subs_voxels': clean(t.p_subs_voxels)};
}
