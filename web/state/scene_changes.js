import {same} from './store.js';

const live_material = ['edge_stiffness', 'diagonal_stiffness', 'edge_modulus', 'diagonal_modulus', 'damping'];
const live_pose = ['position', 'orientation'];
const not_of_the_start = ['density', 'friction', 'restitution', 'self_contact'];

/// What a running simulation must be told to get from one scene to another: a PATCH, colliders' new poses, and
/// whether anything is left that needs compiling anew (structural), and then the run to start again (restarts).
export function difference(before, after) {
  const patch = {};
  for (const name of ['gravity', 'solver']) if (!same(before[name], after[name])) patch[name] = after[name];
  const materials = [], moves = [];
  after.bodies.forEach((body, index) => {
    const old = before.bodies[index];
    if (!old) return;
    const moved = body.type === 'rigid' && live_pose.some(name => !same(body[name], old[name]));
    if (moved) moves.push({body: index, position: body.position ?? [0, 0, 0], orientation: body.orientation ?? [0, 0, 0, 1]});
    if (live_material.some(name => body[name] !== old[name]))
      materials.push({body: index, ...Object.fromEntries(live_material.map(name => [name, body[name]]))});
  });
  if (materials.length) patch.materials = materials;
  return {patch, moves, structural: !same(frozen(before), frozen(after)), restarts: !same(start(before), start(after))};
}

/// What a run begins with: other rigid bodies and materials do not undo where the deformable ones have got to.
function start(scene) {
  const {bodies, ...rest} = frozen(scene);
  const begun = ({type, ...body}) => type === 'deformable' && Object.fromEntries(Object.entries(body).filter(([name]) => !not_of_the_start.includes(name)));
  return {...rest, bodies: bodies.map(begun).filter(Boolean)};
}

/// The scene without what can change while it runs.
function frozen({gravity, solver, ...rest}) {
  const fixed = body => {
    const live = body.type === 'rigid' ? live_pose : live_material;
    return Object.fromEntries(Object.entries(body).filter(([name]) => !live.includes(name)));
  };
  return {...rest, bodies: rest.bodies.map(fixed)};
}
