import * as THREE from 'three';
import {solid_material} from './shading.js';

const grid_vertex = `
  out vec2 at;
  out float distance_to_eye;
  void main() {
    at = position.xy;
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    distance_to_eye = length(view.xyz);
    gl_Position = projectionMatrix * view;
  }`;
const grid_fragment = `
  precision highp float;
  uniform vec3 ink;
  uniform float reach;
  in vec2 at;
  in float distance_to_eye;
  out vec4 color;
  float lines(float spacing) {
    vec2 cell = at / spacing;
    vec2 width = fwidth(cell);
    vec2 line = abs(fract(cell - 0.5) - 0.5) / max(width, vec2(1e-6));
    return (1.0 - min(min(line.x, line.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
  }
  void main() {
    float fade = 1.0 - smoothstep(0.3 * reach, reach, length(at));
    float strength = max(0.22 * lines(0.1), 0.5 * lines(1.0)) * fade;
    color = vec4(ink, 1.0) * (strength + 0.05 * fade);
  }`;

/// Of all grids; the style sheet says it (--grid).
export const grid_ink = {value: new THREE.Color('#8593a8')};

/// The ground: lines every 0.1 m and stronger ones every metre, fading out.
export function grid_mesh(reach = 4) {
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: grid_vertex, fragmentShader: grid_fragment, transparent: true,
    depthWrite: false, premultipliedAlpha: true, side: THREE.DoubleSide,
    uniforms: {ink: grid_ink, reach: {value: reach}},
  });
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(2 * reach, 2 * reach), material);
  mesh.renderOrder = -1;
  return mesh;
}

const shape_geometry = {
  sphere: ({radius}) => new THREE.SphereGeometry(radius, 48, 32),
  box: ({half_extents}) => new THREE.BoxGeometry(...half_extents.map(x => 2 * x)),
  capsule: ({radius, half_height}) => new THREE.CapsuleGeometry(radius, 2 * half_height, 12, 32),
};

function mesh_geometry(body) {
  const geometry = new THREE.BufferGeometry();
  const surface = body.surface ?? new Int32Array();
  const flat = new Float32Array(3 * surface.length);
  surface.forEach((vertex, i) => flat.set(body.rest_positions.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
  geometry.setAttribute('position', new THREE.BufferAttribute(flat, 3));
  return geometry;
}

/// A rigid body's shape in its own frame.
export function collider_mesh(body) {
  const [[kind, values]] = Object.entries(body.shape ?? {mesh: {}});
  if (kind === 'plane') return plane_group(values);
  const made = kind === 'mesh' ? mesh_geometry(body) : shape_geometry[kind](values).toNonIndexed();
  for (const name of ['normal', 'uv']) made.deleteAttribute(name);
  made.setAttribute('value', new THREE.BufferAttribute(new Float32Array(made.attributes.position.count), 1));
  const mesh = new THREE.Mesh(made, solid_material({color: '#6f86a6', edges: 0}));
  mesh.scale.setScalar(body.scale ?? 1);
  return mesh;
}

function plane_group({normal, offset}) {
  const group = new THREE.Group();
  const grid = grid_mesh();
  const n = new THREE.Vector3(...normal).normalize();
  grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), n);
  grid.position.copy(n.multiplyScalar(offset));
  group.add(grid);
  return group;
}
