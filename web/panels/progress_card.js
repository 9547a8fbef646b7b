import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {about, milliseconds, words} from '../ui/format.js';
import {unnoticed} from '../work/meshing.js';

const long_step = 2000;  // milliseconds without a frame

/// Long work shows what it does, how far it is, and can be cancelled; short work shows nothing.
export function progress_card({meshing, cancel, simulation, end_run}) {
  const bar = h('progress', {max: '1', 'aria-label': 'Progress'});
  const text = h('span');
  const card = h('div', {class: 'card progress-card', hidden: true}, text, bar, button('Cancel', cancel));
  meshing.addEventListener('progress', () => {
    const {reading} = meshing, job = meshing.busy ? meshing.job : null;
    card.hidden = !reading && (!job || performance.now() - meshing.started < unnoticed);
    if (card.hidden) return;
    if (reading) return bar.removeAttribute('value'), text.textContent = `Opening ${reading.name}`;
    bar.value = job.fraction ?? 0;
    text.textContent = `${words(job.phase || 'waiting')}${job.eta_s ? ` · ${about(job.eta_s)} left` : ''}`;
  });
  return [card, long_step_card(simulation, end_run)];
}

/// A scene that its solver can hardly meet may take long for a step.
function long_step_card(simulation, end_run) {
  const text = h('span');
  const card = h('div', {class: 'card progress-card', hidden: true}, text, h('progress', {'aria-label': 'A long step'}), button('End this run', end_run));
  setInterval(() => {
    const waited = simulation.state === 'playing' && simulation.replaying === null ? performance.now() - simulation.heard : 0;
    card.hidden = waited < long_step;
    if (!card.hidden) text.textContent = `Step ${(simulation.buffer.last?.seq ?? 0) + 1} · ${milliseconds(waited)} so far`;
  }, 500);
  return card;
}
