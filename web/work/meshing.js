import {load, load_ahead, make_preview} from '../wire/data.js';
import {precision} from '../wire/decode.js';
import {sample_path} from './first_requests.js';
import {cancel_job, finish_job} from '../wire/jobs.js';

export const stage_names = ['distance_field', 'pseudo_volume', 'lattice', 'tetrahedra', 'smoothing', 'embedding'];

// Milliseconds that a preview may take while others wait: were each cut off by the next, none would be seen, and the
// distance field that the first one makes serves those after it.
const preview_patience = 2000;

// Most cells along a preview's longest edge; how coarse they become is what their pictures take.
const preview_cells = [12, 16, 24, 32];

// Milliseconds from a slider's move to its picture: where moves wait as long as the preview before them takes, longer ones
// would come too late, and after much shorter ones there is time for more cells.
const too_long = 90, short = 35;

/// Milliseconds of work before it shows how far it is.
export const unnoticed = 300;

const models_path = '/models?wait_ms=100';

/// From where all that is drawn of a mesh counts, in its own coordinates: its middle, where it is so far from their origin
/// that single precision would show.
function origin_of({min, max}) {
  const middle = min.map((low, axis) => (low + max[axis]) / 2), size = Math.max(...max.map((high, axis) => high - min[axis]));
  return Math.max(...middle.map(Math.abs)) > 30 * size ? middle : [0, 0, 0];
}

/// The way from the mesh and the parameters of the state to a model. The newest request wins: while a slider moves,
/// coarse previews follow each other; its release supersedes what is under way.
/// Events: mesh, stages, model, cells, voxels, problem, progress.
export class Meshing extends EventTarget {
  constructor(client, store) {
    super();
    Object.assign(this, {client, store, mesh: null, geometry: null, model: null, cells: null, voxels: null, problem: null});
    this.stages = Object.fromEntries(stage_names.map(name => [name, {state: 'stale', ms: null, reused: false}]));
    this.job = null;
    this.waiting = null;
    this.detail = 1;  // of preview_cells
    this.busy = false;
    this.files = new Map();  // of a person, by the id of their mesh
    store.on('params', live => this.shows(store.get('mesh')) && this.request(live));
  }

  tell(name) {
    this.dispatchEvent(new Event(name));
  }

  /// Whether the state's mesh is the one that is open.
  shows({sample, id}) {
    return sample ? this.sample === sample : Boolean(id) && this.mesh?.id === id;
  }

  /// The sample, the file of a person, or the known mesh; given up when another is opened meanwhile. take() runs once it
  /// is known, before anything is asked of it.
  async open({sample = null, id, file}, take = () => {}) {
    const turn = this.turn = Symbol('open');
    const give_way = () => {
      if (this.turn !== turn) throw new DOMException('Another mesh is opened', 'AbortError');
    };
    this.opening = true;
    this.abort?.abort();
    const reading = this.reading = Object.assign(new AbortController(), {name: file?.name ?? sample ?? id});
    const late = setTimeout(() => this.tell('progress'), unnoticed);
    const mesh = await this.fetch_mesh({sample, id, file}, reading).finally(() => {
      clearTimeout(late);
      if (this.turn !== turn) return;
      this.opening = false;
      this.reading = null;
      this.tell('progress');
    });
    give_way();
    take();
    Object.assign(this, {mesh, sample, origin: origin_of(mesh.report.bounds), made_with: null, preview: false});
    this.model = this.cells = this.voxels = this.problem = null;
    const geometry = load(this.client, ...geometry_of(mesh, this.origin));
    this.request(false);
    this.tell('mesh');
    const shape = await geometry;
    give_way();
    this.geometry = shape;
    this.tell('geometry');
  }

  async fetch_mesh({sample, id, file}, {signal}) {
    if (sample) return this.client.send('POST', sample_path(sample), undefined, {signal});
    if (file) return this.upload(file, signal);
    return this.client.get(`/meshes/${id}`).catch(problem => {
      if (problem.status !== 404 || !this.files.has(id)) throw problem;
      return this.upload(this.files.get(id), signal);
    });
  }

  async upload(file, signal) {
    try {
      const response = await this.client.request('POST', `/meshes?name=${encodeURIComponent(file.name)}`, {body: file, signal});
      const mesh = {...await response.json(), name: file.name};  // the server may know its content by another
      this.files.set(mesh.id, file);
      return mesh;
    } catch (problem) {
      throw Object.assign(problem, {file: file.name});
    }
  }

  /// live: a preview is enough, for the slider still moves.
  request(live) {
    if (!this.mesh || this.opening) return;
    const params = this.store.get('params');
    if (this.busy && live && this.previewing && performance.now() - this.started < preview_patience) {
      this.waiting = {live};
      return;
    }
    this.waiting = null;
    this.run(params, live);
  }

  async run(params, live) {
    const mesh = this.mesh;
    this.abort?.abort();
    const abort = this.abort = new AbortController();
    this.busy = true;
    this.previewing = live;
    this.started = performance.now();
    if (!live) this.problem = null;  // of what was asked for before
    this.mark_changed(params);
    try {
      const made = await this.make_model(model_request(mesh, params, live && preview_cells[this.detail]), abort);
      if (abort.signal.aborted) return;
      await this.adopt(made, params, live, abort);
    } catch (error) {
      if (!abort.signal.aborted && error.name !== 'AbortError') this.fail(error, live);
    }
    if (this.abort === abort && this.busy) this.go_on();
  }

  /// What was asked for meanwhile is next.
  go_on() {
    this.busy = false;
    this.tell('progress');
    if (this.waiting) this.request(this.waiting.live);
  }

  async make_model(request, {signal}) {
    if (this.job) request.supersedes = this.job.id;
    const preview = request.drawing && await make_preview(this.client, models_path, request, this.origin);
    if (preview && signal.aborted) cancel_job(this.client, preview);
    signal.throwIfAborted();
    let job = preview || await this.client.send('POST', models_path, request, {signal});
    this.job = job;
    const result = await finish_job(this.client, job, {signal, on_progress: now => {
      this.job = job = now;
      this.tell('progress');
    }});
    this.job = null;
    return {...result, cells: job.drawing};
  }

  async adopt({model_id, model, cells}, params, live, abort) {
    const asked = this.asked = (this.asked ?? 0) + 1, {mesh} = this;
    cells ??= await load(this.client, `/models/${model_id}`, 'load_cells', this.origin);
    if (asked < this.asked || mesh !== this.mesh) return;
    Object.assign(this, {model, cells, voxels: null, problem: null, preview: live, made_with: structuredClone(params)});
    const now = performance.now();
    this.took_ms = now - this.started;
    // Of a preview whose picture is awaited. The first of a mesh makes its distance field, and says nothing of the next.
    this.unpaced = live && model.stages[0].reused ? {since: now} : null;
    const made = Object.fromEntries(model.stages.map(({name, ms, reused}) => [name, {state: 'fresh', ms, reused}]));
    for (const name of stage_names) this.stages[name] = made[name] ?? {...this.stages[name], state: 'stale'};  // of a preview
    if (this.abort === abort) this.go_on();  // the server works while this model is drawn
    this.tell('stages');
    this.tell('model');
  }

  /// Chooses how coarse the next previews are, by what this one and its picture took.
  pace({from, ms}) {
    if (!this.unpaced || from < this.unpaced.since) return;  // of what was drawn before
    const picture_ms = from - this.unpaced.since + ms;
    this.unpaced = null;
    const last = 2 * this.took_ms + picture_ms;  // of a move just after it was asked for
    if (last > too_long) this.detail = Math.max(0, this.detail - 1);
    else if (last < short) this.detail = Math.min(preview_cells.length - 1, this.detail + 1);
  }

  /// Of a preview that is empty nothing is said: it is coarse, and the whole model may have cells.
  fail(problem, live = false) {
    const phase = this.job?.phase;
    this.job = null;
    for (const stage of Object.values(this.stages)) if (stage.state === 'running') stage.state = 'stale';
    if (live && problem.code === 'empty_result') return this.tell('stages');
    this.problem = problem;
    // Of an empty model the phase is that of the settings that were tried after it.
    const failed = problem.code === 'empty_result' ? 'lattice' : phase ?? stage_names.find(name => this.stages[name].state === 'stale');
    if (this.stages[failed] && problem.code !== 'server_lost') this.stages[failed].state = 'failed';
    this.tell('stages');
    this.tell('problem');
  }

  cancel() {
    if (this.reading) return this.reading.abort();
    this.abort?.abort();
    this.busy = false;
    for (const stage of Object.values(this.stages)) if (stage.state === 'running') stage.state = 'stale';
    this.tell('stages');
    this.tell('progress');
  }

  /// The model with all its stages, of what was last asked for: a preview will not do, nor one that is being replaced.
  async whole_model() {
    if (this.model && !this.preview && !this.busy) return this.model;
    if (this.problem?.code === 'empty_result' && !this.busy) throw this.problem;  // again, with the ways on
    return new Promise((resolve, reject) => {
      const check = () => !this.preview && this.model && done(() => resolve(this.model));
      const fail = () => done(() => reject(this.problem));
      const done = end => {
        this.removeEventListener('model', check);
        this.removeEventListener('problem', fail);
        end();
      };
      this.addEventListener('model', check);
      this.addEventListener('problem', fail);
      if (!this.busy) this.request(false);
    });
  }

  async load_voxels() {
    const {model} = this;
    if (!model || this.voxels || this.loading_voxels === model) return;
    this.loading_voxels = model;
    const voxels = await load(this.client, `/models/${model.id}`, 'load_voxels', this.origin);
    if (this.model !== model) return;
    this.voxels = voxels;
    this.tell('voxels');
  }

  mark_changed(params) {
    const changed = this.made_with ? Object.keys(params).filter(name => params[name] !== this.made_with[name]) : null;
    const first = changed ? Math.min(...changed.map(name => stage_names.indexOf(this.stage_of(name)))) : 0;
    this.mark_from(stage_names[Number.isFinite(first) ? Math.max(0, first) : stage_names.length - 1], 'running');
  }

  mark_from(first, state) {
    for (const name of stage_names.slice(stage_names.indexOf(first))) this.stages[name].state = state;
    this.tell('stages');
  }

  stage_of(name) {
    return this.stage_by_name?.[name];
  }
}

/// preview_cells: of a preview; false asks for the full model.
const model_request = (mesh, params, preview_cells) => ({mesh_id: mesh.id, params: wire_params(params),
  ...preview_cells ? {quality: 'preview', preview_cells, drawing: true} : {quality: 'full'}});

const geometry_of = (mesh, origin) => [`/meshes/${mesh.id}/geometry${precision(origin)}`, 'load', origin];

/// Asks for what is drawn of a mesh while there is no page yet to draw it on.
export function ask_for_picture(client, mesh, params) {
  load_ahead(client, ...geometry_of(mesh, origin_of(mesh.report.bounds)));
  client.ahead('POST', models_path, model_request(mesh, params, false));
}

/// Absent values have their defaults on the server.
export const wire_params = params => Object.fromEntries(Object.entries(params).filter(([, value]) => value !== null));
