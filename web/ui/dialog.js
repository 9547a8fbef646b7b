import {h, unique_id} from './dom.js';
import {button} from './fields.js';

/// A native modal dialog: made, shown, and gone when it closes. Returns its element.
export function open_dialog(title, ...content) {
  const id = unique_id('dialog');
  const dialog = h('dialog', {'aria-labelledby': id},
    h('header', {}, h('h2', {id}, title), button('', () => dialog.close(), {name: 'close', label: 'Close', class: 'plain'})),
    h('div', {class: 'content'}, content));
  dialog.addEventListener('close', () => dialog.remove());
  dialog.addEventListener('click', event => event.target === dialog && dialog.close());
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}
