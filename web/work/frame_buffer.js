const byte_limit = 256e6;

/// The frames that arrived, in order of seq, for scrubbing; the oldest go when they take more than 256 MB.
export class FrameBuffer {
  constructor() {
    this.clear();
  }

  clear() {
    this.frames = [];
    this.bytes = 0;
  }

  add(frame) {
    const last = this.frames.at(-1);
    if (last && frame.seq <= last.seq) this.drop_from(frame.seq);
    this.frames.push(frame);
    this.bytes += size(frame);
    while (this.bytes > byte_limit && this.frames.length > 2) this.bytes -= size(this.frames.shift());
  }

  /// A restart begins again at 0, and overwrites.
  drop_from(seq) {
    while (this.frames.length && this.frames.at(-1).seq >= seq) this.bytes -= size(this.frames.pop());
  }

  get first() {
    return this.frames[0] ?? null;
  }

  get last() {
    return this.frames.at(-1) ?? null;
  }

  /// The newest frame that is not after seq, or the first one.
  at(seq) {
    let low = 0, high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle].seq <= seq) low = middle;
      else high = middle - 1;
    }
    return this.frames[low] ?? null;
  }
}

const size = frame => 512 + frame.bodies.reduce((sum, body) => sum + (body.positions?.byteLength ?? 0), 0);
