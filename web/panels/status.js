import {h} from '../ui/dom.js';
import {count, counted, milliseconds, number} from '../ui/format.js';

/// One line that says what happened last, read out by screen readers.
export function status_line({meshing, simulation, events}) {
  const line = h('span', {role: 'status', 'aria-live': 'polite', class: 'message'});
  const server = h('span', {class: 'server'});
  meshing.addEventListener('mesh', () => line.textContent = `${meshing.mesh.name}: ${counted(meshing.mesh.report.triangles, 'triangles')}`);
  meshing.addEventListener('model', () => {
    const {model, preview, took_ms} = meshing;
    line.replaceChildren(`${preview ? 'Preview: ' : ''}${counted(model.tets, 'tets')} in ${milliseconds(took_ms)} · smallest dihedral ${number(model.min_dihedral_deg)}° · ${count(model.inverted)} inverted`,
      model.complete === false ? h('strong', {class: 'warn'}, ' · incomplete: see Model in the inspector') : '');
  });
  simulation.addEventListener('pausing', () => line.textContent = 'Pausing after this step…');
  let told = null;
  simulation.addEventListener('state', () => {
    if (simulation.state === told) return;
    told = simulation.state;
    const words = {none: '', preparing: 'Compiling the scene…', playing: 'Playing', paused: 'Paused', finished: 'The simulation has finished', recording: 'Recording loaded'};
    if (words[simulation.state] !== undefined) line.textContent = words[simulation.state];
  });
  events.addEventListener('say', ({detail}) => line.textContent = detail);
  events.addEventListener('server', ({detail}) => server.textContent = detail);
  return h('footer', {class: 'status'}, line, server);
}
