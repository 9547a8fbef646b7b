// Fetches and decodes bulk data, and prepares what is drawn, off the main thread.
import {count_from, decode_tree, precision} from './decode.js';
import {boundary_cells, cell_centers} from '../view/cell_faces.js';
import {face_neighbours} from '../view/cell_topology.js';
import {voxel_faces} from '../view/voxel_faces.js';

async function load({url, origin, ...request}) {
  const response = await fetch(url, request);
  const document = await response.json().catch(() => ({title: response.statusText, status: response.status}));
  if (!response.ok) throw document;
  const buffers = [];
  const decoded = decode_tree(document, buffers);
  count_from(origin, decoded.drawing ?? decoded, buffers);
  return [decoded, buffers];
}

/// Adds the neighbours across the cells' faces and their centres.
function prepare(cells, buffers) {
  const neighbour = face_neighbours(cells.tets, cells.cells);
  const boundary = boundary_cells(neighbour), centers = cell_centers(cells);
  buffers.push(neighbour.buffer, boundary.buffer, centers.cells.buffer);
  return {...cells, neighbour, boundary, centers};
}

const tasks = {
  load,
  /// Tets of a model with their quality, prepared.
  async load_cells({url, headers, origin}) {
    const parts = [`tets${precision(origin)}`, 'quality'];
    const [[tets, a], [quality, b]] = await Promise.all(parts.map(name => load({url: `${url}/${name}`, headers, origin})));
    const buffers = [...a, ...b];
    return [prepare({...quality, ...tets}, buffers), buffers];
  },
  /// Asks for a preview: its job, with the drawing prepared once it is done.
  async make_preview({url, headers, body, origin}) {
    const [job, buffers] = await load({url: `${url}${precision(origin).replace('?', '&')}`, method: 'POST', origin, body,
      headers: {...headers, 'Content-Type': 'application/json'}});
    return [{...job, drawing: job.drawing && prepare(job.drawing, buffers)}, buffers];
  },
  /// The neighbours across the faces of cells that are known otherwise.
  neighbours({tets, cells}) {
    const neighbour = face_neighbours(tets, cells);
    return [{neighbour}, [neighbour.buffer]];
  },
  async load_voxels({url, headers, origin}) {
    const [voxels, buffers] = await load({url: `${url}/voxels?shell=false`, headers, origin});
    const faces = voxel_faces(voxels);
    const made = [faces.face_voxel.buffer, faces.face_direction.buffer];
    return [{...voxels, ...faces}, [...buffers, ...made]];
  },
};

self.addEventListener('message', async ({data}) => {
  const {id, task, ...message} = data;
  try {
    const [value, buffers] = await tasks[task](message);
    self.postMessage({id, value}, [...new Set(buffers)]);
  } catch (error) {
    const problem = error instanceof Error
      ? {code: 'server_lost', title: 'The data could not be read', detail: error.message} : error;
    self.postMessage({id, problem});
  }
});
