import * as THREE from 'three';

const half_size = {
  sphere: ({radius}) => [radius, radius, radius],
  box: ({half_extents}) => half_extents,
  capsule: ({radius, half_height}) => [radius, radius + half_height, radius],
};

/// World box of the rigid bodies and lattices of a scene; planes have none.
export function scene_bounds({bodies}) {
  const box = new THREE.Box3();
  for (const body of bodies) {
    const position = new THREE.Vector3(...body.position ?? [0, 0, 0]);
    const [[kind, values] = []] = Object.entries(body.shape ?? {});
    if (half_size[kind]) {
      const half = new THREE.Vector3(...half_size[kind](values));
      box.union(new THREE.Box3(position.clone().sub(half), position.clone().add(half)));
    }
    if (body.lattice) box.union(lattice_box(body.lattice, position));
  }
  return box;
}

/// A box with what lies under its middle on the scene's planes, to which its bodies may fall.
export function with_ground(box, {bodies}) {
  const all = box.clone(), middle = box.getCenter(new THREE.Vector3());
  for (const {shape} of bodies.filter(body => body.shape?.plane)) {
    const plane = new THREE.Plane(new THREE.Vector3(...shape.plane.normal).normalize(), -shape.plane.offset);
    all.expandByPoint(plane.projectPoint(middle, new THREE.Vector3()));
  }
  return all;
}

function lattice_box({cells, cell_size, origin}, position) {
  const low = new THREE.Vector3(...origin).add(position);
  return new THREE.Box3(low, low.clone().add(new THREE.Vector3(...cells).multiplyScalar(cell_size)));
}
