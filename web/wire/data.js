import {Problem} from './client.js';

const worker = new Worker('data_worker.js', {type: 'module'});
const waiting = new Map();
let next_id = 0;

worker.addEventListener('message', ({data}) => {
  const {resolve, reject} = waiting.get(data.id);
  waiting.delete(data.id);
  if (data.problem) reject(new Problem(data.problem));
  else resolve(data.value);
});

/// Work off the main thread: see data_worker.js for the tasks.
export function ask(task, message, transfer = []) {
  const id = ++next_id;
  return new Promise((resolve, reject) => {
    waiting.set(id, {resolve, reject});
    worker.postMessage({id, task, ...message}, transfer);
  });
}

/// A preview's job and drawing from one request that no other work on the main thread holds up; null where it fails, which
/// the usual way then explains.
export function make_preview(client, path, request, origin) {
  const message = {url: client.absolute(path), headers: client.credentials(), body: JSON.stringify(request), origin};
  return ask('make_preview', message).catch(() => null);
}

const begun = new Map();

/// GET of a document with bulk arrays, decoded into typed arrays; `task` may prepare them for drawing as well. Positions
/// and grids count from the origin.
export function load(client, path, task = 'load', origin = [0, 0, 0]) {
  const data = begun.get(path) ?? ask(task, {url: client.absolute(path), headers: client.credentials(), origin});
  begun.delete(path);
  return data;
}

/// Begins to load before anybody asks; the first who does takes it.
export function load_ahead(client, path, ...how) {
  const data = load(client, path, ...how);
  data.catch(() => {});
  begun.set(path, data);
}
