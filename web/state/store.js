/// The page's state: a JSON tree, changed only by commands {label, changes: [{path, before, after}]}, which gives
/// undo, redo and the URL. A gesture (a slider being dragged, an orbit) previews its changes live and is committed
/// as one command.
export class Store extends EventTarget {
  constructor(state) {
    super();
    this.state = state;
    this.undo_stack = [];
    this.redo_stack = [];
    this.gesture = null;
  }

  get(path) {
    return path.split('.').reduce((node, key) => node?.[key], this.state);
  }

  /// One step of the history. changes: {path: value}.
  set(changes, label) {
    this.commit();
    this.record(changes, label);
    this.commit();
  }

  /// Shows the changes at once, without a step in the history until commit().
  preview(changes, label) {
    this.record(changes, label);
    this.announce(Object.keys(changes), true);
  }

  record(changes, label) {
    this.gesture ??= {label, before: new Map()};
    this.gesture.label = label;
    for (const [path, after] of Object.entries(changes)) {
      if (!this.gesture.before.has(path)) this.gesture.before.set(path, copy(this.get(path)));
      write(this.state, path, copy(after));
    }
  }

  commit() {
    const {label, before} = this.gesture ?? {};
    this.gesture = null;
    if (!before) return;
    this.push(label, before);
    this.announce([...before.keys()], false);
  }

  /// One step of the history from what the values of some paths were: [[path, before]].
  push(label, before) {
    const changes = [...before].map(([path, value]) => ({path, before: value, after: copy(this.get(path))}));
    const moved = changes.filter(change => !same(change.before, change.after));
    if (!moved.length) return;
    this.undo_stack.push({label, changes: moved});
    this.redo_stack = [];
  }

  /// What follows from the last step becomes a part of it.
  amend(changes) {
    for (const [path, after] of Object.entries(changes)) {
      this.undo_stack.at(-1)?.changes.push({path, before: copy(this.get(path)), after: copy(after)});
      write(this.state, path, copy(after));
    }
    this.announce(Object.keys(changes), false);
  }

  /// What came about since the values were these becomes a step.
  remember(before, label) {
    this.commit();
    this.push(label, Object.entries(before));
    this.announce([], false);
  }

  /// Changes that a person did not make (defaults from the server, a scene fitted to a mesh): no history.
  adopt(changes) {
    for (const [path, value] of Object.entries(changes)) write(this.state, path, copy(value));
    this.announce(Object.keys(changes), false);
  }

  undo() {
    this.commit();
    this.replay(this.undo_stack, this.redo_stack, 'before');
  }

  redo() {
    this.commit();
    this.replay(this.redo_stack, this.undo_stack, 'after');
  }

  replay(from, to, side) {
    const command = from.pop();
    if (!command) return;
    to.push(command);
    for (const change of command.changes) write(this.state, change.path, copy(change[side]));
    this.announce(command.changes.map(change => change.path), false, true);
  }

  announce(paths, live, replayed = false) {
    this.dispatchEvent(new CustomEvent('change', {detail: {paths, live, replayed}}));
  }

  /// The same store for controls that come and go: their listeners end with dispose().
  scope() {
    const end = new AbortController();
    const scoped = {on: (paths, f) => this.on(paths, f, end.signal), dispose: () => end.abort()};
    for (const name of ['get', 'set', 'preview', 'commit']) scoped[name] = this[name].bind(this);
    return scoped;
  }

  /// f(live, replayed) whenever something at, above or below one of the paths changes; replayed by undo or redo.
  on(paths, f, signal) {
    const watched = [paths].flat();
    const touches = (a, b) => a === b || a.startsWith(`${b}.`) || b.startsWith(`${a}.`);
    this.addEventListener('change', ({detail}) => {
      if (detail.paths.some(path => watched.some(w => touches(path, w)))) f(detail.live, detail.replayed);
    }, {signal});
  }
}

export const copy = value => value === undefined ? null : structuredClone(value);
export const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

function write(state, path, value) {
  const keys = path.split('.');
  const last = keys.pop();
  const node = keys.reduce((at, key) => at[key] ??= {}, state);
  node[last] = value;
}
