import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {milliseconds, words} from '../ui/format.js';

/// Long work shows what it does, how far it is, and can be cancelled; short work shows nothing.
export function progress_card({meshing, cancel}) {
  const bar = h('progress', {max: '1', 'aria-label': 'Progress'});
  const text = h('span');
  const card = h('div', {class: 'card progress-card', hidden: true}, text, bar, button('Cancel', cancel));
  meshing.addEventListener('progress', () => {
    const job = meshing.busy ? meshing.job : null;
    card.hidden = !job || performance.now() - meshing.started < 300;
    if (card.hidden) return;
    bar.value = job.fraction ?? 0;
    text.textContent = `${words(job.phase || 'waiting')}${job.eta_s ? ` · ${milliseconds(1000 * job.eta_s)} left` : ''}`;
  });
  return card;
}
