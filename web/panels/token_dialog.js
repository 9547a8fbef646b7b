import {h, unique_id} from '../ui/dom.js';
import {open_dialog} from '../ui/dialog.js';

/// Asks for the token of a server on another machine, keeps it for this tab and starts the page anew.
export function ask_for_token(client) {
  const id = unique_id('token');
  const field = h('input', {type: 'password', id, required: true, autocomplete: 'off'});
  const form = h('form', {class: 'row'}, h('label', {for: id}, 'Token'), field, h('button', {class: 'primary'}, 'Connect'));
  form.addEventListener('submit', event => {
    event.preventDefault();
    client.keep_token(field.value.trim());
    location.reload();
  });
  open_dialog('This server asks for its token', h('p', {}, 'It stands where the server was started, after --token.'), form);
}
