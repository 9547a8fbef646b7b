import {ask, load} from '../wire/data.js';
import {FrameBuffer} from './frame_buffer.js';

/// One simulation on the server (or a recording), its frames and the place shown.
/// Events: bodies, frame (the shown one), frames, state, pausing, problem, lost.
export class Simulation extends EventTarget {
  constructor(client) {
    super();
    Object.assign(this, {client, id: null, state: 'none', info: null, plan: null, bodies: [], shown: null, speed: 1});
    this.buffer = new FrameBuffer();
    this.worker = new Worker('stream_worker.js', {type: 'module'});
    this.worker.addEventListener('message', ({data}) => this.receive(data));
    this.generation = 0;
    this.replaying = null;
    this.recording = false;
    this.opening = Promise.resolve();  // of the bodies in a stream's first line
  }

  tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, {detail}));
  }

  /// Compiles the scene on the server; resolves when its bodies are known and their first frame is on its way. Continuing,
  /// time and the bodies' motion go on from the present run.
  async create(scene, continuing = false) {
    this.continued = continuing;
    const before = continuing ? this.id : null;
    await this.close(before);
    const generation = ++this.generation;
    if (!before) this.set_state('preparing');
    const further = before ? `&continues=${before}${this.state === 'playing' ? '&state=playing' : ''}` : '';
    try {
      let info = await this.client.send('POST', `/simulations?wait_ms=2000${further}`, scene);
      if (generation !== this.generation) return void [info.id, before].map(id => this.remove(id));
      this.id = info.id;
      while (info.state === 'preparing' && generation === this.generation) {
        await new Promise(resolve => setTimeout(resolve, 100));
        info = await this.client.get(`/simulations/${info.id}`);
      }
      this.remove(before);
      if (info.state === 'failed') throw Object.assign(new Error(info.problem?.detail), info.problem);
      if (generation !== this.generation) return;
      this.take_info(info);
      const topology = await load(this.client, `/simulations/${info.id}/topology`);
      if (generation !== this.generation) return;
      await this.set_bodies(topology.bodies);
      this.follow();
      await this.first_frame();
      if (generation !== this.generation) return;
      this.set_state(info.state);
      if (this.speed !== 1) await this.patch({speed: this.speed});
    } catch (error) {
      if (generation === this.generation) this.set_state('none');
      throw error;
    }
  }

  take_info(info) {
    this.info = info;
    this.plan = info.plan ?? this.plan;
  }

  async set_bodies(bodies) {
    this.bodies = await Promise.all(bodies.map(async body => body.type === 'deformable'
      ? {...body, ...await ask('neighbours', {tets: body.tets, cells: body.cells})} : body));
    this.buffer.clear();
    this.shown = null;
    this.tell('bodies');
  }

  /// Frame 0, before anything is asked of the simulation: later ones would overtake it.
  first_frame() {
    return new Promise(resolve => {
      const done = () => {
        for (const name of ['frame', 'bodies', 'problem']) this.removeEventListener(name, done);
        resolve();
      };
      for (const name of ['frame', 'bodies', 'problem']) this.addEventListener(name, done);
    });
  }

  follow() {
    const url = this.client.absolute(`/simulations/${this.id}/frames`);
    this.worker.postMessage({task: 'follow', url, headers: this.client.credentials(), generation: this.generation});
  }

  async receive(data) {
    if (data.recorded) return this.finish_recording(data);
    if (data.generation !== this.generation) return;
    if (data.closed) return this.opening.then(() => this.closed(data.problem, data.generation));
    if (data.replayed) return this.set_state('recording');
    const {line} = data;
    if (line.type === 'hello') await (this.opening = this.hello(line));
    else if (line.type === 'frame') this.take_frame(line);
    else if (line.type === 'state') this.set_state(line.state);
    else if (line.type === 'error') this.tell('problem', line.problem);
    else if (line.type === 'end') this.ended = true;
  }

  async hello(line) {
    this.plan = line.plan ?? this.plan;
    if (!line.bodies) return;
    this.info = {...line, frame_rate: line.frame_rate};
    this.early_frames = [];
    await this.set_bodies(line.bodies);
    const early = this.early_frames;
    this.early_frames = null;
    for (const frame of early) this.take_frame(frame);
  }

  take_frame(frame) {
    this.heard = performance.now();
    if (this.early_frames) return void this.early_frames.push(frame);
    const from_file = this.state === 'recording' || this.state === 'reading';
    const follows = this.replaying === null && !from_file && this.shown === this.buffer.last;
    this.buffer.add(frame);
    if (follows || !this.shown) this.show(frame);  // not while a person looks at an earlier one
    this.tell('frames');
  }

  show(frame) {
    if (!frame) return;
    this.shown = frame;
    this.tell('frame');
  }

  set_state(state) {
    if (this.state === 'reading' && state !== 'recording' && state !== 'none' && state !== 'preparing') return;
    this.state = state;
    this.heard = performance.now();
    this.tell('state');
  }

  closed(problem, generation) {
    if (generation !== this.generation || this.ended || this.state === 'none' || this.state === 'recording') return;
    if (problem) this.tell('problem', problem);
    else this.tell('lost');
    if (this.state === 'reading') this.set_state(this.shown ? 'recording' : 'none');  // what could be read
  }

  async patch(changes) {
    if (!this.id) return;
    this.take_info(await this.client.send('PATCH', `/simulations/${this.id}`, changes));
    this.set_state(this.info.state);
  }

  /// The file of a recording, dropped on the page; true when it begins as one.
  async replay(file) {
    await this.close();
    this.continued = false;
    this.set_state('reading');
    this.worker.postMessage({task: 'replay', file, generation: ++this.generation});
    return new Promise(resolve => {
      const done = ({type}) => {
        for (const name of ['bodies', 'problem']) this.removeEventListener(name, done);
        resolve(type === 'bodies');
      };
      for (const name of ['bodies', 'problem']) this.addEventListener(name, done);
    });
  }

  start_recording() {
    const from = (this.shown?.seq ?? 0) - 1;
    const url = this.client.absolute(`/simulations/${this.id}/frames?pace=every&topology=inline&after_seq=${from}`);
    this.worker.postMessage({task: 'record', url, headers: this.client.credentials()});
    this.recording = true;
    this.tell('state');
  }

  /// The file: from the frame that was shown at its start to the last one that has come.
  async stop_recording() {
    this.recording = false;
    const finished = new Promise(resolve => this.finish_recording = resolve);
    this.worker.postMessage({task: 'end_recording', until: this.buffer.last?.seq ?? -1});
    this.tell('state');
    const {recorded, problem} = await finished;
    if (problem) throw problem;
    return recorded;
  }

  /// Ends the run, unless another is to take it over.
  async close(kept = null) {
    const {id} = this;
    this.id = null;
    this.ended = false;
    this.replaying = null;
    ++this.generation;
    this.worker.postMessage({task: 'close'});
    if (id !== kept) await this.remove(id);
  }

  /// Nothing is left of the last run.
  forget() {
    this.close();
    Object.assign(this, {continued: false, info: null, plan: null, bodies: [], shown: null});
    this.buffer.clear();
    this.tell('bodies');
    this.set_state('none');
  }

  async remove(id) {
    if (id) await this.client.request('DELETE', `/simulations/${id}`).catch(() => {});
  }
}
