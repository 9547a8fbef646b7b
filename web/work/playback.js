/// Play, pause, step, restart and scrub: through the frames that were buffered, then on with the live simulation.
export class Playback {
  constructor(simulation) {
    Object.assign(this, {simulation, starting: false});
    simulation.addEventListener('bodies', () => this.stop_replay());
  }

  get playing() {
    return this.simulation.replaying !== null || this.simulation.state === 'playing';
  }

  get at_end() {
    const {shown, buffer} = this.simulation;
    return !shown || shown.seq >= (buffer.last?.seq ?? 0);
  }

  /// While the scene is compiled to be played.
  set_starting(starting) {
    this.starting = starting;
    this.simulation.tell('state');
  }

  async play() {
    if (!this.at_end || this.simulation.state === 'recording') return this.start_replay();
    if (this.simulation.state === 'finished') return this.restart(true);
    await this.simulation.patch({state: 'playing'});
  }

  async pause() {
    this.stop_replay();
    if (this.simulation.state !== 'playing') return;
    // Its stream may have told that it has paused, before the answer comes.
    const late = setTimeout(() => this.simulation.state === 'playing' && this.simulation.tell('pausing'), 300);
    await this.simulation.patch({state: 'paused'}).finally(() => clearTimeout(late));
  }

  async step(frames) {
    const {simulation} = this;
    await this.pause();
    const wanted = (simulation.shown?.seq ?? 0) + frames;
    if (frames < 0 || !this.at_end) return simulation.show(simulation.buffer.at(Math.max(0, wanted)));
    if (simulation.id && !this.playing) await simulation.client.send('POST', `/simulations/${simulation.id}/steps`, {count: frames});
  }

  async restart(play = false) {
    this.stop_replay();
    const {simulation} = this;
    if (simulation.state === 'recording') return simulation.show(simulation.buffer.first);
    simulation.buffer.clear();
    simulation.shown = null;
    await simulation.patch({restart: true, state: play ? 'playing' : 'paused'});
  }

  async scrub(seq) {
    this.stop_replay();
    this.simulation.show(this.simulation.buffer.at(seq));
    await this.pause();
  }

  set_speed(speed) {
    this.simulation.speed = speed;
    if (this.simulation.id) return this.simulation.patch({speed});
  }

  start_replay() {
    const {simulation} = this;
    const rate = simulation.info?.frame_rate ?? 60;
    const from = this.at_end ? simulation.buffer.first : simulation.shown;
    let [start, seq] = [performance.now(), from.seq];
    const tick = now => {
      if (simulation.replaying === null) return;
      seq += (now - start) / 1000 * rate * simulation.speed;
      start = now;
      simulation.show(simulation.buffer.at(Math.floor(seq)));
      if (seq < simulation.buffer.last.seq) return void (simulation.replaying = requestAnimationFrame(tick));
      this.stop_replay();
      if (simulation.state === 'paused') simulation.patch({state: 'playing'});
    };
    simulation.replaying = requestAnimationFrame(tick);
    simulation.tell('state');
  }

  stop_replay() {
    if (this.simulation.replaying === null) return;
    cancelAnimationFrame(this.simulation.replaying);
    this.simulation.replaying = null;
    this.simulation.tell('state');
  }
}
