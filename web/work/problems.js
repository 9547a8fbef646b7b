import {suggestions} from '../state/suggestions.js';
import {words} from '../ui/format.js';
import {param_changes, settle} from '../state/constraints.js';

/// Turns refusals into cards with a one-click way on.
export function report_problems(app) {
  const {meshing, simulation} = app;
  app.report = problem => app.tell('problem', {problem, actions: ways_on(app, problem)});
  app.ways_from_text = text => suggestions(text, app).map(({title, values}) => ({title, run: () => set_params(app, values, title)}));
  meshing.addEventListener('problem', () => app.report(meshing.problem));
  meshing.addEventListener('model', () => app.tell('solved'));
  simulation.addEventListener('bodies', () => app.tell('solved'));
  simulation.addEventListener('problem', ({detail}) => app.report(detail));
}

const set_params = ({store}, values, label) => store.set(param_changes(settle(store.get('params'), values)), label);

function ways_on(app, problem) {
  const actions = [...app.ways_from_text(problem.hint ?? ''), ...nearest_allowed(app, problem)];
  if (app.store.undo_stack.length && problem.status === 422) actions.push({title: 'Undo the last change', run: app.undo});
  if (!actions.length && problem.code !== 'server_lost') actions.push({title: 'Back to the sample tree', run: () => app.open_sample('tree')});
  return actions.slice(0, 3);
}

/// A field out of range becomes the nearest value that is allowed.
function nearest_allowed(app, {errors = []}) {
  return errors.filter(({max}) => Number.isFinite(max)).map(({pointer, min, max}) => ({name: pointer.split('/').at(-1), min, max}))
    .filter(({name}) => name in app.defaults)
    .map(({name, min, max}) => {
      const value = Math.min(max, Math.max(min ?? -Infinity, app.store.get(`params.${name}`)));
      const title = `Set ${words(name)} to ${value}`;
      return {title, run: () => set_params(app, {[name]: value}, title)};
    });
}
