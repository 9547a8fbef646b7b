// Fetches and decodes bulk data, and prepares what is drawn, off the main thread.
import {count_from, decode_tree, precision} from './decode.js';
import {boundary_cells, cell_centers} from '../view/cell_faces.js';
import {face_neighbours} from '../view/cell_topology.js';
import {voxel_faces} from '../view/voxel_faces.js';

async function load({url, headers, origin}) {
  const response = await fetch(url, {headers});
  const document = await response.json().catch(() => ({title: response.statusText, status: response.status}));
  if (!response.ok) throw document;
  const buffers = [];
  const decoded = decode_tree(document, buffers);
  count_from(origin, decoded, buffers);
  return [decoded, buffers];
}

const tasks = {
  load,
  /// Tets of a model with their quality, the neighbours across its cells' faces, and the cells' centres.
  async load_cells({url, headers, origin}) {
    const parts = [`tets${precision(origin)}`, 'quality'];
    const [[tets, a], [quality, b]] = await Promise.all(parts.map(name => load({url: `${url}/${name}`, headers, origin})));
    const neighbour = face_neighbours(tets.tets, tets.cells);
    const boundary = boundary_cells(neighbour), centers = cell_centers(tets);
    return [{...quality, ...tets, neighbour, boundary, centers}, [...a, ...b, neighbour.buffer, boundary.buffer, centers.cells.buffer]];
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
