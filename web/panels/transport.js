import {h, once_a_frame} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {icon} from '../ui/icons.js';
import {milliseconds} from '../ui/format.js';

const speeds = [0.1, 0.25, 0.5, 1, 2, 4];

/// Play, pause, step, restart, record, speed and the scrub bar.
export function transport(app) {
  const {simulation, playback, store, meshing} = app;
  const play = button('', () => app.toggle_play(), {name: 'play', label: 'Play (Space)', class: 'primary play'});
  const back = button('', () => app.step(-1), {name: 'back', label: 'Step back (,)'});
  const forward = button('', () => app.step(1), {name: 'forward', label: 'Step (.)'});
  const restart = button('', () => app.restart(), {name: 'restart', label: 'Restart (Home)'});
  const record = button('', () => app.toggle_recording(), {name: 'record', label: 'Record (R)'});
  const leave = button('', () => app.close_recording(), {name: 'close', label: 'Close the recording'});
  const speed = h('select', {'aria-label': 'Speed', title: 'Speed'}, speeds.map(value => h('option', {value: String(value), selected: value === 1}, `${value}×`)));
  speed.addEventListener('change', () => store.set({speed: Number(speed.value)}, 'Speed'));
  store.on('speed', () => speed.value = String(store.get('speed')));
  const scrub = h('input', {type: 'range', class: 'scrub', min: '0', max: '0', value: '0', step: '1', 'aria-label': 'Frame'});
  const scrub_to = once_a_frame(seq => app.run(() => playback.scrub(seq)));
  scrub.addEventListener('input', () => scrub_to(Number(scrub.value)));  // read now: a frame that comes sets it
  const time = h('span', {class: 'time'});
  const show_place = once_a_frame(() => {
    const {shown, buffer} = simulation;
    scrub.disabled = buffer.frames.length < 2;
    scrub.min = buffer.first?.seq ?? 0;
    scrub.max = buffer.last?.seq ?? 0;
    scrub.value = shown?.seq ?? 0;
    scrub.style.setProperty('--fill', `${100 * (scrub.value - scrub.min) / Math.max(1, scrub.max - scrub.min)}%`);
    scrub.setAttribute('aria-valuetext', shown ? `frame ${shown.seq}, ${shown.t.toFixed(2)} seconds` : 'no frame yet');
    time.textContent = shown ? `${shown.t.toFixed(2)} s · step ${shown.seq} · ${milliseconds(shown.metrics?.step_ms)}`
      : playback.starting || simulation.state === 'preparing' ? 'compiling…' : meshing.model ? 'ready to play' : 'no model yet';
  });
  const show_state = () => {
    const playing = playback.playing || playback.starting;
    play.replaceChildren(icon(playing ? 'pause' : 'play'));
    play.setAttribute('aria-label', playing ? 'Pause (Space)' : 'Play (Space)');
    play.title = play.getAttribute('aria-label');
    play.setAttribute('aria-busy', String(playback.starting));
    record.hidden = simulation.state === 'recording';
    leave.hidden = !record.hidden;
    record.setAttribute('aria-pressed', String(simulation.recording));
    record.classList.toggle('recording', simulation.recording);
  };
  for (const name of ['frame', 'frames', 'bodies']) simulation.addEventListener(name, show_place);
  simulation.addEventListener('state', () => (show_state(), show_place()));
  meshing.addEventListener('mesh', show_place);
  meshing.addEventListener('model', () => meshing.preview || show_place());
  show_state();
  show_place();
  return h('section', {class: 'transport', 'aria-label': 'Transport'}, restart, back, play, forward, record, leave, speed, scrub, time);
}
