import {h} from '../ui/dom.js';
import {button} from '../ui/fields.js';
import {sentence} from '../ui/format.js';
import {in_titles} from '../state/suggestions.js';

/// What went wrong, where, and a way on: one card a problem, the newest below; of files only the last one stands.
export function problem_cards(app) {
  const {events} = app;
  const list = h('div', {class: 'problems', role: 'alert'});
  events.addEventListener('problem', ({detail: {problem, actions = []}}) => {
    for (const old of [...list.children]) if (old.dataset.code === String(problem.code) || problem.file && old.dataset.file) old.remove();
    list.append(problem_card(app, problem, actions));
  });
  events.addEventListener('solved', ({detail: code}) => {
    for (const card of [...list.children]) if (!code || card.dataset.code === code) card.remove();
  });
  return list;
}

/// Beginning with the file that it is about.
function what_and_where({detail, message, title, file = ''}) {
  const what = detail ?? message ?? title;
  return what.includes(file) ? sentence(what) : `${file}: ${what}`.replace(/[^.!?]$/, '$&.');
}

function problem_card(app, problem, actions) {
  const details = problem.errors?.map(({pointer, detail}) => h('li', {}, `${pointer.replace('/', '')}: ${detail}`)) ?? [];
  const card = h('div', {class: 'problem-card', 'data-code': String(problem.code), 'data-file': problem.file},
    h('strong', {}, what_and_where(problem)),
    details.length > 1 ? h('ul', {}, details) : null,
    problem.hint ? h('p', {class: 'quiet'}, sentence(in_titles(problem.hint, app))) : null,
    h('div', {class: 'actions'},
      actions.map(({title, run}) => button(title, () => (card.remove(), run()), {class: 'primary'})),
      button('Dismiss', () => card.remove())));
  return card;
}
