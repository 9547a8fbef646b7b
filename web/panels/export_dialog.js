import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {open_dialog} from '../ui/dialog.js';
import {download} from '../ui/dom.js';
import {capital, counted} from '../ui/format.js';
import {animation_formats} from '../wire/animation.js';

/// By consumer: what each gets, in which units and winding, with one click.
export async function export_dialog(app) {
  const {formats, exports} = await app.client.get('/formats');
  const list = formats ?? exports;
  const ready = Boolean(app.meshing.model);
  open_dialog('Export',
    h('p', {class: 'quiet'}, 'The present model, with positive winding, in the units of the file. The same settings give the same bytes.'),
    ready ? null : h('p', {}, 'There is no model yet.'),
    h('h3', {}, 'Model'),
    h('ul', {class: 'exports'}, list.map(format => export_row(app, format, ready))),
    h('h3', {}, 'Animation'),
    animation_rows(app),
    h('h3', {}, 'Settings'),
    h('ul', {class: 'exports'},
      row('Parameters for the command line', 'JSON for isochor mesh --params', '.json', button('Save', app.save_params, {name: 'save', label: 'Save the parameters'})),
      row('Scene for the command line', 'JSON for isochor simulate, with the mesh beside it', '.json', button('Save', app.save_scene, {name: 'save', label: 'Save the scene'}))));
}

function row(title, note, extension, ...actions) {
  return h('li', {}, h('div', {}, h('strong', {}, title), h('span', {class: 'badge'}, extension), h('p', {class: 'quiet'}, note)), actions);
}

function export_row(app, {name, extension, consumers, conventions}, ready) {
  const save = button('Save', () => app.save_export(name), {name: 'save', label: `Save for ${consumers}`, disabled: !ready});
  return row(capital(consumers), conventions, extension, save);
}

function animation_rows(app) {
  const frames = app.simulation.buffer.frames.length;
  if (frames < 2) return h('p', {class: 'quiet'}, 'Play a simulation first; its buffered frames become the clip.');
  return h('ul', {class: 'exports'}, animation_formats.map(({title, note, extension, make}) =>
    row(title, `${note} ${counted(frames, 'frames')}.`, extension, button('Save', () => app.run(async () => {
      download(make(app.simulation, app.stem()), `${app.stem()}${extension}`);
      app.say(`${title} saved with ${counted(frames, 'frames')}`);
    }), {name: 'save', label: `Save ${title}`}))));
}
