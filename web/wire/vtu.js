import {cell_volumes} from '../view/deformation.js';
import {make_tar} from './tar.js';

const tetra = 10;  // VTK_TETRA

/// A ParaView series in one archive: a .vtu a frame with the tets, the displacement of their vertices and the volume
/// error of their cells, and the .pvd that gives each its time. VTK's XML format with raw appended data.
export function make_vtu_series({body, frames, rate, stem}) {
  const tets = body.tets.length / 4;
  const topology = [
    ['connectivity', 'Int32', Int32Array.from(body.tets)],
    ['offsets', 'Int32', Int32Array.from({length: tets}, (_, k) => 4 * (k + 1))],
    ['types', 'UInt8', new Uint8Array(tets).fill(tetra)]];
  const rest = Float32Array.from(body.rest_positions);
  const rest_volumes = cell_volumes(rest, body.tets);
  const name = k => `${stem}_${String(k).padStart(4, '0')}.vtu`;
  const files = frames.map((positions, k) => {
    const volumes = cell_volumes(positions, body.tets);
    const error = Float32Array.from({length: tets}, (_, t) => {
      const cell = Math.floor(t / 5);
      return Math.abs(volumes[cell] - rest_volumes[cell]) / rest_volumes[cell];
    });
    return {name: name(k), parts: vtu_parts(positions, positions.map((x, i) => x - rest[i]), error, topology)};
  });
  return make_tar([{name: `${stem}.pvd`, parts: [pvd(frames.map((_, k) => [k / rate, name(k)]))]}, ...files]);
}

const pvd = sets => `<?xml version="1.0"?>
<VTKFile type="Collection" version="1.0" byte_order="LittleEndian"><Collection>
${sets.map(([time, file]) => `<DataSet timestep="${time}" part="0" file="${file}"/>`).join('\n')}
</Collection></VTKFile>
`;

function vtu_parts(positions, displacement, error, topology) {
  const appended = [];
  let offset = 0;
  const array = (name, type, values, components = 1) => {
    appended.push(Uint32Array.of(values.byteLength), values);
    const tag = `<DataArray type="${type}" Name="${name}" NumberOfComponents="${components}" format="appended" offset="${offset}"/>`;
    offset += 4 + values.byteLength;
    return tag;
  };
  const head = `<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32"><UnstructuredGrid>
<Piece NumberOfPoints="${positions.length / 3}" NumberOfCells="${error.length}">
<Points>${array('Points', 'Float32', positions, 3)}</Points>
<Cells>${topology.map(([name, type, values]) => array(name, type, values)).join('')}</Cells>
<PointData>${array('displacement', 'Float32', displacement, 3)}</PointData>
<CellData>${array('volume_error', 'Float32', error)}</CellData>
</Piece></UnstructuredGrid>
<AppendedData encoding="raw">_`;
  return [head, ...appended, '</AppendedData></VTKFile>\n'];
}
