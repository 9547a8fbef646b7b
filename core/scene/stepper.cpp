#include "core/scene/stepper.h"

#include <algorithm>
#include <ranges>

#include "core/dynamics/inversion.h"
#include "core/scene/detect_contacts.h"

namespace isochor {
namespace {

constexpr int max_halvings = 5;
constexpr int max_recovery_rounds = 30;
/// The active set of contacts usually stands after two rounds; later rounds only add, so that it ends.
constexpr int max_contact_rounds = 10;
constexpr int release_rounds = 6;
constexpr double grab_frequency = 10.0;  ///< rad/s

}  // namespace

StepStats Stepper::frame(double seconds, const Progress& progress) {
  stats_ = StepStats{};
  const double h = seconds / world_.substeps;
  stats_.smallest_h = h;
  for (int s = 0; s < world_.substeps; ++s) {
    progress.throw_if_cancelled();
    advance(h, 0);
  }
  return stats_;
}

void Stepper::advance(double h, int halvings) {
  const bool began_inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  stats_.smallest_h = std::min(stats_.smallest_h, h);
  const StepStats before = stats_;
  ++stats_.substeps;
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.begin_step(h), world_.rigid.solve(); });
  predict_all(h);
  for (SceneSoftBody& soft : world_.soft) constrain(soft, h);
  world_.phases.run(Phase::inversion, [&] {
    for (SceneSoftBody& soft : world_.soft)
      soft.inverted = any_inverted(*soft.body.mesh, soft.body.positions);
  });
  const bool inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  if (inverted && !began_inverted && halvings < max_halvings) {
    const double smallest = stats_.smallest_h;
    stats_ = before;
    stats_.smallest_h = smallest;
    for (SceneSoftBody& soft : world_.soft) restore_start(soft.body), soft.inverted = false;
    advance(0.5 * h, halvings + 1);
    advance(0.5 * h, halvings + 1);
    return;
  }
  for (SceneSoftBody& soft : world_.soft) finish_velocities(soft, h);
  if (inverted) {
    ++stats_.recoveries;
    world_.phases.run(Phase::inversion, [&] {
      for (SceneSoftBody& soft : world_.soft)
        if (soft.inverted) recover(soft);
    });
  }
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.end_step(); });
}

void Stepper::add_forces(SoftBody& body) {
  if (body.forces.size() == 0) return;
  for (auto* axis : {&body.forces.x, &body.forces.y, &body.forces.z}) std::ranges::fill(*axis, 0.0);
  const SpringMaterial& m = body.material;
  world_.phases.run(Phase::edge_springs, [&] {
    add_spring_forces(body.springs.edges, m.edge, m.damping, body.positions, body.velocities, body.forces);
  });
  world_.phases.run(Phase::diagonal_springs, [&] {
    add_spring_forces(body.springs.diagonals, m.diagonal, m.damping, body.positions, body.velocities,
                      body.forces);
  });
}

void Stepper::predict_all(double h) {
  PhaseList& phases = world_.phases;
  for (SceneSoftBody& soft : world_.soft) {
    SoftBody& body = soft.body;
    keep_start(body);
    phases.run(Phase::gravity, [&] { kick_by_gravity(body, h, world_.scene.gravity); });
    add_forces(body);
    phases.run(Phase::grab, [&] { follow_grab(soft, h); });
    phases.run(Phase::symplectic_euler, [&] {
      if (body.forces.size() > 0) kick_by_forces(body, h);
      drift(body, h);
    });
    phases.run(Phase::pins, [&] { follow_pins(soft); });
  }
}

// A critically damped spring that could swing the whole body, taken implicitly so that any h is stable.
void Stepper::follow_grab(SceneSoftBody& soft, double h) {
  const Grab& grab = *world_.grab;
  SoftBody& body = soft.body;
  if (grab.body != soft.id || grab.vertex < 0 || grab.vertex >= std::ssize(body.inverse_masses)) return;
  const double w = body.inverse_masses[grab.vertex], mass = body.total_mass;
  const double k = mass * grab_frequency * grab_frequency, c = 2.0 * mass * grab_frequency;
  const Vec3 pull = k * (grab.target - body.positions.at(grab.vertex));
  const Vec3 v = body.velocities.at(grab.vertex);
  body.velocities.set(grab.vertex, (v + h * w * pull) / (1.0 + h * w * (h * k + c)));
}

void Stepper::follow_pins(SceneSoftBody& soft) {
  for (const PinnedParticle& pin : soft.pins) {
    const Vec3 target =
        pin.rigid < 0 ? pin.anchor : world_.rigid.predicted_pose(pin.rigid).to_world(pin.anchor);
    soft.body.positions.set(pin.particle, target);
  }
}

void Stepper::constrain(SceneSoftBody& soft, double h) {
  ProjectionResult result;
  if (!soft.contacts) {
    result = project(soft);
    stats_.iterations += result.iterations;
    return record(soft, result);
  }
  ParticleContacts& contacts = *soft.contacts;
  contacts.begin(soft.body);
  for (int round = 0; round < max_contact_rounds; ++round) {
    bool changed = round == 0;
    world_.phases.run(Phase::contacts, [&] {
      if (round > 0) changed |= contacts.update(soft.body, round <= release_rounds);
      changed |= detect_contacts(soft.body, world_.rigid, h, contacts);
      contacts.place(soft.body);
    });
    if (!changed) break;
    result = project(soft);
    stats_.iterations += result.iterations;
    if (contacts.empty() && round > 0) break;
  }
  record(soft, result);
}

ProjectionResult Stepper::project(SceneSoftBody& soft) {
  ProjectionResult result;
  world_.phases.run(Phase::volume, [&] {
    ProjectionRequest request;
    request.start = &soft.body.start_positions;
    if (soft.contacts) {
      request.blocked = soft.contacts->blocked();
      request.blocked_forces = soft.contacts->blocked_forces();
    }
    request.tolerance = world_.scene.solver.tolerance;
    request.max_iterations = world_.scene.solver.max_iterations;
    result = soft.body.projector->project(request, soft.body.positions);
  });
  return result;
}

void Stepper::record(const SceneSoftBody& soft, const ProjectionResult& result) {
  if (!result.kept_directions) ++stats_.fallbacks;
  if (soft.contacts) stats_.contacts = soft.contacts->count();
  if (result.converged) return;
  stats_.feasible = false;
  if (result.max_error < stats_.worst_error) return;
  stats_.worst_error = result.max_error;
  stats_.worst_body = soft.id;
  stats_.worst_cell = result.worst_cell;
}

void Stepper::finish_velocities(SceneSoftBody& soft, double h) {
  velocities_from_positions(soft.body, h);
  if (soft.contacts) world_.phases.run(Phase::restitution, [&] { soft.contacts->bounce(soft.body, h); });
}

void Stepper::recover(SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  ProjectionRequest request;
  request.tolerance = world_.scene.solver.tolerance;
  request.max_iterations = world_.scene.solver.max_iterations;
  if (soft.contacts) request.blocked = soft.contacts->blocked();
  for (int round = 0; round < max_recovery_rounds && soft.inverted; ++round) {
    pull_flattened_cells(body, body.positions);
    lift_inverted_tets(body, body.positions);
    const ProjectionResult result = body.projector->project(request, body.positions);
    stats_.iterations += result.iterations;
    soft.inverted = any_inverted(*body.mesh, body.positions);
  }
}

}  // namespace isochor
