// Scenes that the page builds around the current model. The body that stands for it names its mesh "current".

const turn_z_up = [-Math.SQRT1_2, 0, 0, Math.SQRT1_2];

/// Where the mesh stands: its longest edge becomes one metre (fit) or its unit a metre's fraction, its up axis y, its
/// base at the height given.
export function placement(bounds, {up = 'y', fit = true, unit = 1}, height = 0) {
  const size = bounds.max.map((x, axis) => x - bounds.min[axis]);
  const scale = fit ? 1 / (Math.max(...size) || 1) : unit;
  const orientation = up === 'z' ? turn_z_up : [0, 0, 0, 1];
  const [low, high] = ['min', 'max'].map(side => rotate(bounds[side], up).map(x => x * scale));
  const min = low.map((x, axis) => Math.min(x, high[axis])), max = low.map((x, axis) => Math.max(x, high[axis]));
  const position = [-(min[0] + max[0]) / 2, height - min[1], -(min[2] + max[2]) / 2];
  const box = {min: min.map((x, axis) => x + position[axis]), max: max.map((x, axis) => x + position[axis])};
  return {position, orientation, scale, box};
}

const rotate = ([x, y, z], up) => up === 'z' ? [x, z, -y] : [x, y, z];

const ground = {name: 'ground', type: 'rigid', shape: {plane: {normal: [0, 1, 0], offset: 0}}, static: true};
const round = x => Number(x.toPrecision(6));

function base(name, place, body = {}, more = {}) {
  return {
    name, duration: null, frame_rate: 60, gravity: [0, -9.81, 0],
    solver: {volume: 'newton', constraint: 'per_cell', tolerance: 1e-6, springs: 'auto', substeps: 'auto', max_iterations: 40},
    bodies: [{name: 'body', type: 'deformable', mesh: 'current', position: place.position.map(round),
      orientation: place.orientation, scale: round(place.scale), density: 300, masses: 'lumped',
      edge_stiffness: 3000, diagonal_stiffness: 1000, damping: 0, friction: 0.3, restitution: 0.2, self_contact: false,
      ...body}],
    pins: [], joints: [], ...more,
  };
}

const at_height = (bounds, options, height) => placement(bounds, options, height);
const half_sizes = ({box}) => box.max.map((x, axis) => round((x - box.min[axis]) / 2));

export const scene_templates = {
  sway: {
    title: 'Sway', meaning: 'Held at its foot, bent aside and let go, without gravity.',
    make(bounds, options) {
      const place = at_height(bounds, options, 0);
      const foot = round(place.box.min[1] + 0.06 * (place.box.max[1] - place.box.min[1]));
      return base('sway', place, {edge_stiffness: 150, diagonal_stiffness: 60, start: {affine: [[1, 0.3, 0], [0, 1, 0], [0, 0.1, 1]]}}, {
        gravity: [0, 0, 0], pins: [{body: 'body', inside: {min: [-1e3, -1e3, -1e3], max: [1e3, foot, 1e3]}, to: null}],
      });
    },
  },
  drop: {
    title: 'Drop', meaning: 'Falls on the ground.',
    make: (bounds, options) => base('drop', at_height(bounds, options, 0.5), {}, {bodies_after: [ground]}),
  },
  sphere: {
    title: 'Drop on a sphere', meaning: 'Falls on a rigid sphere, as in the paper.',
    make(bounds, options) {
      const ball = {name: 'ball', type: 'rigid', shape: {sphere: {radius: 0.25}}, static: true, position: [0.05, 0.25, 0]};
      return base('sphere', at_height(bounds, options, 0.8), {}, {bodies_after: [ground, ball]});
    },
  },
  squash: {
    title: 'Squash', meaning: 'Pressed between two plates to 70 % of its height.',
    make(bounds, options) {
      const place = at_height(bounds, options, 0.02);
      const half = half_sizes(place), height = 2 * half[1];
      const extents = [round(half[0] + 0.3), 0.02, round(half[2] + 0.3)];
      const plate = (name, y, more) => ({name, type: 'rigid', shape: {box: {half_extents: extents}}, position: [0, round(y), 0], ...more});
      return base('squash', place, {friction: 0.1}, {bodies_after: [
        plate('bottom plate', -0.002, {static: true}),
        plate('top plate', height + 0.042, {motion: {velocity: [0, round(-0.3 * height), 0], until: 1}}),
      ]});
    },
  },
  twist: {
    title: 'Twist', meaning: 'Twisted by a sixth of a turn and let go without gravity.',
    make: (bounds, options) => base('twist', at_height(bounds, options, 0), {edge_stiffness: 300, diagonal_stiffness: 100, start: {twist_deg: 60}}, {gravity: [0, 0, 0]}),
  },
};

// What the server takes where a scene says nothing (core/scene/scene.h), for the fields to show.
const usual = {
  scene: {gravity: [0, -9.81, 0]},
  solver: {volume: 'newton', springs: 'auto', substeps: 'auto', tolerance: 1e-6},
  deformable: {density: 1000, damping: 0, friction: 0.3, restitution: 0},
  stiffness: {edge: 1e4, diagonal: 1e3},
};

/// The same scene with all that its fields show.
export function complete_scene(scene) {
  const stiffness = body => Object.fromEntries(Object.entries(usual.stiffness)
    .filter(([name]) => body[`${name}_modulus`] === undefined).map(([name, value]) => [`${name}_stiffness`, value]));
  return {...usual.scene, ...scene, solver: {...usual.solver, ...scene.solver},
    bodies: scene.bodies.map(body => body?.type === 'deformable' ? {...usual.deformable, ...stiffness(body), ...body} : body)};
}

/// The template of a scene that came from a file or a sample.
export const own_scene = 'own';

export function make_scene(template, bounds, options) {
  const {bodies_after = [], ...scene} = (scene_templates[template] ?? scene_templates.sway).make(bounds, options);
  return {...scene, bodies: [...scene.bodies, ...structuredClone(bodies_after)]};
}

export const file_name = path => path.split('/').at(-1);

/// Paths of the meshes that a scene names by their files.
export const mesh_files = ({bodies}) => [...new Set(bodies.flatMap(({mesh, shape}) => [mesh, shape?.mesh?.file ?? shape?.mesh]))]
  .filter(path => path && path !== 'current');

/// What POST /simulations takes: the model's id in place of "current", and what id_of knows in place of files.
export function wire_scene(scene, model_id, id_of) {
  const named = mesh => mesh === 'current' ? model_id : id_of(mesh);
  return {...scene, bodies: scene.bodies.map(body => {
    if (body.mesh) return {...body, mesh: named(body.mesh)};
    const {mesh} = body.shape ?? {};
    if (!mesh) return body;
    return {...body, shape: {mesh: mesh.file ? {...mesh, file: named(mesh.file)} : named(mesh)}};
  })};
}
