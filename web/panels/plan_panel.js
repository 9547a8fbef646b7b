import {h} from '../ui/dom.js';
import {bytes, words} from '../ui/format.js';

/// The phases that the scene was compiled to, and those that were left out, each with its reason.
export function plan_panel({simulation}) {
  const list = h('div', {class: 'plan'});
  const show = () => {
    const plan = simulation.plan ?? [];
    if (!plan.length) return list.replaceChildren(h('p', {class: 'quiet'}, 'Play the scene to see what it is compiled to.'));
    list.replaceChildren(
      h('h3', {}, 'Compiled in'), phases(plan.filter(phase => phase.included)),
      h('h3', {}, 'Left out'), phases(plan.filter(phase => !phase.included)));
  };
  for (const name of ['state', 'bodies']) simulation.addEventListener(name, show);
  show();
  return list;
}

const phases = plan => h('ul', {}, plan.map(({name, reason, bytes: held, ms, included}) =>
  h('li', {}, h('strong', {}, words(name)), included && (held || ms) ? h('span', {class: 'badge'}, [held ? bytes(held) : '', ms ? `${ms.toFixed(0)} ms` : ''].filter(Boolean).join(' · ')) : null,
    h('p', {class: 'quiet'}, reason))));
