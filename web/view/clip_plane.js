import * as THREE from 'three';

const axes = {x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1]};

/// The clip of the view's state as a plane n·x ≤ w in the world, or null when it is off. The position runs from 0
/// (all is removed) to 1 (all is kept) through the box.
export function clip_plane(clip, bounds) {
  if (!clip.on) return null;
  const normal = new THREE.Vector3(...(axes[clip.axis] ?? clip.normal)).normalize();
  if (clip.flip) normal.negate();
  let low = Infinity, high = -Infinity;
  for (let corner = 0; corner < 8; ++corner) {
    const point = new THREE.Vector3(...[0, 1, 2].map(axis => (corner >> axis & 1 ? bounds.max : bounds.min).getComponent(axis)));
    const along = normal.dot(point);
    low = Math.min(low, along);
    high = Math.max(high, along);
  }
  const margin = 0.001 * (high - low);
  return new THREE.Vector4(normal.x, normal.y, normal.z, low - margin + clip.position * (high - low + 2 * margin));
}

/// The same plane in the coordinates of an object that `matrix` places in the world: [nx, ny, nz, w].
export function plane_in(plane, matrix) {
  const normal = new THREE.Vector3(plane.x, plane.y, plane.z);
  const offset = new THREE.Vector3().setFromMatrixPosition(matrix);
  const w = plane.w - normal.dot(offset);
  const local = normal.transformDirection(new THREE.Matrix4().copy(matrix).transpose());
  const scale = new THREE.Vector3().setFromMatrixColumn(matrix, 0).length();
  return [local.x, local.y, local.z, w / scale];
}
