import {words} from '../ui/format.js';

/// Turns refusals into cards with a one-click way on.
export function report_problems(app) {
  const {meshing, simulation} = app;
  app.report = problem => app.tell('problem', {problem, actions: ways_on(app, problem)});
  meshing.addEventListener('problem', () => app.report(meshing.problem));
  meshing.addEventListener('model', () => app.tell('solved'));
  simulation.addEventListener('bodies', () => app.tell('solved'));
  simulation.addEventListener('problem', ({detail}) => app.report(detail));
}

function ways_on(app, problem) {
  const actions = suggested_values(problem).map(([name, value]) =>
    ({title: `Set ${words(name)} to ${value}`, run: () => app.store.set({[`params.${name}`]: value}, `set ${words(name)}`)}));
  if (app.store.undo_stack.length && problem.status === 422) actions.push({title: 'Undo the last change', run: app.undo});
  if (!actions.length && problem.code !== 'server_lost') actions.push({title: 'Back to the sample tree', run: () => app.open_sample('tree')});
  return actions.slice(0, 3);
}

/// "try p_in_voxels 2.5" in a hint, and the nearest allowed value of a field out of range.
function suggested_values({hint = '', errors = []}) {
  const known = [...hint.matchAll(/\b([a-z]+(?:_[a-z]+)*)\s+(?:to\s+|=\s*)?(\d+(?:\.\d+)?)/g)]
    .filter(([, name]) => ['voxels', 'cells', 'density', 'p_in_voxels', 'p_subs_voxels', 'p_in', 'p_subs'].includes(name))
    .map(([, name, value]) => [name, Number(value)]);
  const bounded = errors.filter(({max}) => Number.isFinite(max)).map(({pointer, max}) => [pointer.split('/').at(-1), max]);
  return [...new Map([...known, ...bounded])];
}
