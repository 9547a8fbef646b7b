// Reads a simulation's NDJSON stream, or a recording of one, and decodes its frames off the main thread.
import {decode_array, decode_body, decode_frame, frame_buffers} from './decode.js';

let reading = null;
let recording = null;

async function read_lines(stream, on_line) {
  const reader = stream.pipeThrough(new TextDecoderStream()).getReader();
  let parts = [];
  for (;;) {
    const {value, done} = await reader.read();
    if (done) break;
    let from = 0;
    for (let end = value.indexOf('\n'); end >= 0; end = value.indexOf('\n', from)) {
      parts.push(value.slice(from, end));
      on_line(parts.length === 1 ? parts[0] : parts.join(''));
      parts = [];
      from = end + 1;
    }
    if (from < value.length) parts.push(value.slice(from));
  }
  if (parts.length) on_line(parts.join(''));
}

function post_line(text, generation) {
  if (!text.trim()) return;
  const line = JSON.parse(text);
  if (line.type === 'frame') {
    decode_frame(line);
    self.postMessage({generation, line}, frame_buffers(line));
    return;
  }
  if (line.type === 'hello' && line.bodies) line.bodies = line.bodies.map(decode_body).map(decode_embedded);
  self.postMessage({generation, line});
}

/// A recording says first which bodies its frames move.
function check_first(text) {
  if (!JSON.parse(text || '{}').bodies) throw new Error('its first line does not hold the bodies');
}

function decode_embedded(body) {
  if (!body.embedded) return body;
  const {positions, triangles, tet, weights} = body.embedded;
  body.embedded = {positions: decode_array(positions), triangles: decode_array(triangles, Int32Array),
    tet: decode_array(tet, Int32Array), weights: decode_array(weights)};
  return body;
}

async function follow({url, headers, generation}) {
  reading?.abort();
  const abort = reading = new AbortController();
  try {
    const response = await fetch(url, {headers, signal: abort.signal, cache: 'no-store'});
    if (!response.ok) throw await response.json().catch(() => ({title: response.statusText, status: response.status}));
    await read_lines(response.body, text => post_line(text, generation));
    self.postMessage({generation, closed: true});
  } catch (error) {
    if (!abort.signal.aborted) self.postMessage({generation, closed: true, problem: error instanceof Error ? null : error});
  }
}

async function replay({file, generation}) {
  reading?.abort();
  try {
    let lines = 0;
    await read_lines(file.stream(), text => {
      if (++lines === 1) check_first(text);
      post_line(text, generation);
    });
    if (!lines) check_first('');
    self.postMessage({generation, replayed: true});
  } catch (error) {
    self.postMessage({generation, closed: true, problem: {code: 'cannot_read', file: file.name, title: 'This is not a recording',
      detail: `${file.name} cannot be read as a recording: ${error.message}`,
      hint: 'Drop a file that was recorded here or written by isochor simulate.'}});
  }
}

/// A recording is the stream itself, every frame of it, with the bodies in its first line.
async function record({url, headers}) {
  const made = recording = {abort: new AbortController(), lines: [], seq: -1, until: Infinity};
  try {
    const response = await fetch(url, {headers, signal: made.abort.signal, cache: 'no-store'});
    if (!response.ok) throw await response.json().catch(() => ({title: response.statusText, status: response.status}));
    await read_lines(response.body, text => keep_line(made, text));
  } catch (error) {
    if (!(error instanceof Error)) made.problem = error;
  }
  made.closed = true;
  finish_recording(made);
}

function keep_line(made, text) {
  const {type, seq} = JSON.parse(text);  // throws for a last line that came in part
  made.lines.push(`${text}\n`);
  if (type === 'frame') made.seq = seq;
  finish_recording(made);
}

/// Up to frame `until`, which may be on its way still.
function end_recording({until}) {
  recording.until = until;
  finish_recording(recording);
}

function finish_recording(made) {
  if (made !== recording || made.until === Infinity || made.seq < made.until && !made.closed) return;
  recording = null;
  made.abort.abort();
  self.postMessage({recorded: new Blob(made.lines, {type: 'application/x-ndjson'}), problem: made.problem});
}

const tasks = {follow, replay, record, end_recording, close: () => reading?.abort()};
self.addEventListener('message', ({data: {task, ...message}}) => tasks[task](message));
