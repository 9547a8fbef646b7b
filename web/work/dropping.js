import {h} from '../ui/dom.js';

/// A file dropped anywhere on the page is opened.
export function accept_drops(app) {
  const hint = h('div', {class: 'drop-hint', hidden: true}, 'Drop a mesh, a recording or a scene');
  document.body.append(hint);
  const has_file = event => event.dataTransfer?.types.includes('Files');
  let depth = 0;
  addEventListener('dragenter', event => has_file(event) && (++depth, hint.hidden = false));
  addEventListener('dragleave', event => has_file(event) && (hint.hidden = --depth > 0 ? false : true));
  addEventListener('dragover', event => has_file(event) && event.preventDefault());
  addEventListener('drop', event => {
    if (!has_file(event)) return;
    event.preventDefault();
    depth = 0;
    hint.hidden = true;
    app.open_files([...event.dataTransfer.files]);
  });
}
