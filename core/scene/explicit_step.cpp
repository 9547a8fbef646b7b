#include <algorithm>

#include "core/scene/substep.h"

namespace isochor {
namespace {

constexpr double grab_frequency = 10.0;  ///< rad/s

}  // namespace

Phase stepping_phase(const SceneSoftBody& soft) {
  switch (soft.integrator) {
    case SpringIntegrator::implicit:
      return Phase::implicit_euler;
    case SpringIntegrator::energy_momentum:
      return Phase::energy_momentum;
    default:
      return Phase::symplectic_euler;
  }
}

void evaluate_forces(World& world, SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  soft.forces_valid = true;
  if (body.forces.size() == 0 || soft.implicit) return;
  for (auto* axis : {&body.forces.x, &body.forces.y, &body.forces.z}) std::ranges::fill(*axis, 0.0);
  const SpringMaterial& m = body.material;
  world.phases.run(Phase::edge_springs, [&] {
    add_spring_forces(body.springs.edges, m.edge, m.damping, body.positions, body.velocities, body.forces);
  });
  world.phases.run(Phase::diagonal_springs, [&] {
    add_spring_forces(body.springs.diagonals, m.diagonal, m.damping, body.positions, body.velocities,
                      body.forces);
  });
}

void kick(World& world, SceneSoftBody& soft, double seconds) {
  SoftBody& body = soft.body;
  world.phases.run(Phase::gravity, [&] { kick_by_gravity(body, seconds, world.scene.gravity); });
  if (body.forces.size() > 0 && !soft.implicit)
    world.phases.run(stepping_phase(soft), [&] { kick_by_forces(body, seconds); });
}

// A critically damped spring that could swing the whole body, taken implicitly so that any h is stable.
void follow_grab(const Substep& step, SceneSoftBody& soft) {
  const Grab& grab = *step.world.grab;
  SoftBody& body = soft.body;
  if (grab.body != soft.id || grab.vertex < 0 || grab.vertex >= std::ssize(body.inverse_masses)) return;
  const double w = body.inverse_masses[grab.vertex], mass = body.total_mass;
  const double k = mass * grab_frequency * grab_frequency, c = 2.0 * mass * grab_frequency;
  const Vec3 pull = k * (grab.target - body.positions.at(grab.vertex));
  const Vec3 v = body.velocities.at(grab.vertex);
  body.velocities.set(grab.vertex, (v + step.h * w * pull) / (1.0 + step.h * w * (step.h * k + c)));
}

void follow_pins(World& world, SceneSoftBody& soft) {
  for (const PinnedParticle& pin : soft.pins) {
    const Vec3 target =
        pin.rigid < 0 ? pin.anchor : world.rigid.predicted_pose(pin.rigid).to_world(pin.anchor);
    soft.body.positions.set(pin.particle, target);
  }
}

}  // namespace isochor
