import {suggestions} from '../state/suggestions.js';
import {param_changes, settle} from '../state/constraints.js';

/// Turns refusals into cards with a one-click way on.
export function report_problems(app) {
  const {meshing, simulation} = app;
  app.report = (problem, again) => app.tell('problem', {problem, actions: ways_on(app, problem, again)});
  app.ways_from_text = text => suggestions(text, app).map(({title, values}) => ({title, run: () => set_params(app, values, title)}));
  meshing.addEventListener('problem', () => app.report(meshing.problem, () => meshing.request(false)));
  meshing.addEventListener('model', () => app.tell('solved'));
  simulation.addEventListener('bodies', () => app.tell('solved'));
  simulation.addEventListener('problem', ({detail}) => app.report(detail, () => simulation.follow()));
}

const set_params = ({store}, values, label) => store.set(param_changes(settle(store.get('params'), values)), label);

function ways_on(app, problem, again) {
  if (problem.missing) return [{title: `Open ${problem.missing.join(' and ')}`, run: () => app.choose_meshes(problem.missing).then(again)}];
  if (problem.file && problem.code !== 'server_lost') return [{title: 'Open another file', run: app.choose_file}];
  const named = app.ways_from_text(problem.hint ?? '');
  const actions = [...named, ...nearest_allowed(app, problem).filter(({title}) => named.every(other => other.title !== title))];
  if (app.store.undo_stack.length && problem.status === 422) actions.push({title: 'Undo the last change', run: app.undo});
  if (!actions.length && problem.code !== 'server_lost')
    actions.push(renewal(app, problem, again) ?? {title: 'Back to the sample tree', run: () => app.open_sample('tree')});
  return actions.slice(0, 3);
}

const busy = [429, 500, 503];

/// What the server no longer has is made again; what it could not do now is asked of it again.
function renewal(app, {status, detail = ''}, again) {
  const {meshing, store} = app;
  const [, gone] = status === 404 || status === 410 ? /\b(model|mesh|simulation) '/.exec(detail) ?? [] : [];
  if (gone === 'model') return {title: 'Mesh it again', run: () => meshing.request(false)};
  const {sample, id} = store.get('mesh');
  if (gone === 'mesh' && (sample || meshing.files.has(id))) return {title: 'Open it again', run: () => app.open({sample, id})};
  if (gone === 'simulation') return {title: 'Start the run again', run: app.start_again};
  return busy.includes(status) && again ? {title: 'Try again', run: again} : null;
}

/// A parameter out of range becomes the nearest value that is allowed; the meshing in a scene's file is not the page's.
function nearest_allowed(app, {errors = []}) {
  return errors.filter(({pointer, max}) => Number.isFinite(max) && !pointer.startsWith('/bodies/'))
    .map(({pointer, min, max}) => ({name: pointer.split('/').at(-1), min, max}))
    .filter(({name}) => name in app.defaults)
    .map(({name, min, max}) => {
      const value = Math.min(max, Math.max(min ?? -Infinity, app.store.get(`params.${name}`)));
      const title = `Set ${app.parameters.find(parameter => parameter.name === name).title} to ${value}`;
      return {title, run: () => set_params(app, {[name]: value}, title)};
    });
}
