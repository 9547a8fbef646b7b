import {h, unique_id} from './dom.js';
import {icon} from './icons.js';

/// A button that opens a native popover with a list of actions; items() is asked anew each time.
/// An item is {title, note?, run} or {heading}.
export function menu_button(title, items) {
  const id = unique_id('menu');
  const menu = h('div', {id, class: 'menu', popover: 'auto', role: 'group', 'aria-label': title});
  const opener = h('button', {type: 'button', popovertarget: id, 'aria-expanded': 'false'}, title, icon('down'));
  menu.addEventListener('beforetoggle', ({newState}) => {
    opener.setAttribute('aria-expanded', String(newState === 'open'));
    if (newState !== 'open') return;
    menu.replaceChildren(...items().map(item => item.heading ? h('h2', {}, item.heading) : entry(menu, item)));
    place(menu, opener);
  });
  menu.addEventListener('toggle', ({newState}) => newState === 'open' && menu.querySelector('button')?.focus());
  menu.addEventListener('keydown', event => walk(menu, event));
  menu.addEventListener('focusout', ({relatedTarget}) => relatedTarget && relatedTarget !== opener && !menu.contains(relatedTarget) && menu.hidePopover());
  return h('span', {}, opener, menu);
}

function entry(menu, {title, note, run}) {
  const act = () => {
    menu.hidePopover();
    run();
  };
  return h('button', {type: 'button', onclick: act}, h('span', {}, title, ' '), note ? h('small', {}, note) : null);
}

function place(menu, opener) {
  const box = opener.getBoundingClientRect();
  menu.style.top = `${box.bottom + 4}px`;
  menu.style.left = `${Math.max(4, Math.min(box.left, innerWidth - 250))}px`;
  menu.style.maxHeight = `${innerHeight - box.bottom - 16}px`;
}

function walk(menu, event) {
  const step = {ArrowDown: 1, ArrowUp: -1}[event.key];
  if (!step) return;
  event.preventDefault();
  const entries = [...menu.querySelectorAll('button')];
  const at = entries.indexOf(document.activeElement);
  entries.at((at + step + entries.length) % entries.length).focus();
}
