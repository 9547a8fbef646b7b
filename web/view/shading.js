import * as THREE from 'three';
import {color_maps} from './color_maps.js';

// One material for everything solid: flat shading from derivatives, a hemisphere and a key light that travel with
// the camera, edges drawn in the fragment (every geometry is a list of triangles, so gl_VertexID tells the corner),
// colour from a map by a scalar a vertex, and a clip plane.
const vertex_shader = `
  in float value;
  in vec3 center;
  uniform float explode;
  uniform vec3 middle;
  out float v_value;
  out vec3 v_view;
  out vec3 v_world;
  out vec3 v_corner;
  void main() {
    vec3 at = explode > 0.0 ? center + explode * (center - middle) + (1.0 - 0.35 * explode) * (position - center) : position;
    vec4 world = modelMatrix * vec4(at, 1.0);
    vec4 view = viewMatrix * world;
    v_world = world.xyz;
    v_view = view.xyz;
    v_value = value;
    v_corner = vec3(0.0);
    v_corner[gl_VertexID % 3] = 1.0;
    gl_Position = projectionMatrix * view;
  }`;

const fragment_shader = `
  precision highp float;
  uniform sampler2D map;
  uniform vec2 range;
  uniform bool logarithmic, mapped, quads, edges_only;
  uniform vec3 base, edge_color;
  uniform float edge_strength;
  uniform vec4 clip;
  uniform bool orthographic, glass;
  in float v_value;
  in vec3 v_view, v_world, v_corner;
  out vec4 color;

  float edge_distance() {
    vec3 pixels = v_corner / max(fwidth(v_corner), vec3(1e-6));
    if (quads) pixels.y = 1e6;  // the diagonal lies opposite the second corner
    return min(pixels.x, min(pixels.y, pixels.z));
  }

  vec3 surface_color() {
    if (!mapped) return base;
    float v = logarithmic ? log(max(v_value, 1e-30)) / log(10.0) : v_value;
    vec3 c = texture(map, vec2(clamp((v - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
    return v_value < 0.0 ? vec3(1.0, 0.05, 0.25) : c;
  }

  void main() {
    if (dot(clip.xyz, v_world) > clip.w) discard;
    vec3 n = normalize(cross(dFdx(v_view), dFdy(v_view)));
    vec3 to_eye = orthographic ? vec3(0.0, 0.0, 1.0) : normalize(-v_view);
    if (dot(n, to_eye) < 0.0) n = -n;
    float edge = edge_strength * (1.0 - smoothstep(0.4, 1.5, edge_distance()));
    if (edges_only && edge < 0.02) discard;
    vec3 albedo = surface_color();
    float hemisphere = 0.5 + 0.5 * n.y;
    float key = max(dot(n, normalize(vec3(-0.45, 0.65, 0.75))), 0.0);
    float rim = pow(1.0 - max(dot(n, to_eye), 0.0), 3.0);
    vec3 lit = albedo * (mix(vec3(0.34, 0.33, 0.36), vec3(0.62, 0.64, 0.68), hemisphere) + 0.55 * key) + 0.05 * rim;
    vec3 shown = edges_only ? mix(albedo, edge_color, 0.3) : mix(lit, edge_color, edge);
    float alpha = edges_only ? edge : glass ? 0.10 + 0.55 * rim : 1.0;
    color = vec4(shown, alpha);
    color.rgb = pow(color.rgb, vec3(1.0 / 2.2));
    color.rgb *= color.a;
  }`;

const textures = new Map();

function map_texture(name) {
  if (!textures.has(name)) {
    const texture = new THREE.DataTexture(color_maps[name], 256, 1);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    textures.set(name, texture);
  }
  return textures.get(name);
}

export const no_clip = new THREE.Vector4(0, 0, 0, 1);

export function solid_material({color = '#8899aa', edges = 0.25, quads = false} = {}) {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: vertex_shader,
    fragmentShader: fragment_shader,
    side: THREE.DoubleSide,
    premultipliedAlpha: true,
    uniforms: {
      map: {value: map_texture('sequential')}, range: {value: new THREE.Vector2(0, 1)},
      logarithmic: {value: false}, mapped: {value: false}, quads: {value: quads}, edges_only: {value: false},
      base: {value: new THREE.Color(color)}, edge_color: {value: new THREE.Color('#10151c')},
      edge_strength: {value: edges}, clip: {value: no_clip}, glass: {value: false},
      orthographic: {value: false}, explode: {value: 0}, middle: {value: new THREE.Vector3()},
    },
  });
}

/// scale: {map, min, max, logarithmic} of the colouring, or null for the plain colour.
export function apply_scale(material, scale) {
  const {uniforms} = material;
  uniforms.mapped.value = Boolean(scale);
  if (!scale) return;
  uniforms.map.value = map_texture(scale.map);
  uniforms.logarithmic.value = Boolean(scale.logarithmic);
  uniforms.range.value.set(scale.min, scale.max);
}

/// Tells the material, as it is drawn, what kind of camera looks.
export function apply_orthographic(mesh) {
  mesh.onBeforeRender = (_renderer, _scene, camera) => {
    mesh.material.uniforms.orthographic.value = camera.isOrthographicCamera === true;
    mesh.material.uniformsNeedUpdate = true;
  };
}

/// A list of triangles that grows but keeps its buffers while they are large enough.
export class TriangleList {
  constructor(material) {
    this.geometry = new THREE.BufferGeometry();
    this.geometry.boundingSphere = new THREE.Sphere();  // nothing is culled by it; computing it would cost more
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
    apply_orthographic(this.mesh);
    this.capacity = -1;
    this.triangles = 0;
  }

  reserve(triangles, with_centers = false) {
    if (triangles > this.capacity || triangles < this.capacity / 8 || with_centers !== Boolean(this.centers)) {
      this.capacity = Math.ceil(triangles * 1.2) + 16;
      this.geometry.dispose();
      this.geometry.deleteAttribute('center');
      if (with_centers) this.geometry.setAttribute('center', dynamic(new Float32Array(9 * this.capacity), 3));
      this.geometry.setAttribute('position', dynamic(new Float32Array(9 * this.capacity), 3));
      this.geometry.setAttribute('value', dynamic(new Float32Array(3 * this.capacity), 1));
    }
    this.positions = this.geometry.attributes.position.array;
    this.values = this.geometry.attributes.value.array;
    this.centers = this.geometry.attributes.center?.array;
  }

  upload(triangles) {
    this.triangles = triangles;
    this.geometry.setDrawRange(0, 3 * triangles);
    for (const attribute of Object.values(this.geometry.attributes)) {
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, 3 * triangles * attribute.itemSize);
      attribute.needsUpdate = true;
    }
  }

  upload_none() {
    this.reserve(0);
    this.upload(0);
  }

  dispose() {
    this.geometry.dispose();
    this.mesh.material.dispose();
  }
}

function dynamic(array, size) {
  const attribute = new THREE.BufferAttribute(array, size);
  attribute.setUsage(THREE.DynamicDrawUsage);
  return attribute;
}
