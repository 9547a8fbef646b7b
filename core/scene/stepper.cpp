#include "core/scene/stepper.h"

#include <algorithm>

namespace isochor {
namespace {

constexpr int max_halvings = 5;

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
  const Substep step{world_, stats_, h};
  const bool began_inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  const StepStats before = stats_;
  ++stats_.substeps;
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.begin_step(h), world_.rigid.solve(); });
  for (SceneSoftBody& soft : world_.soft) predict(step, soft);
  for (SceneSoftBody& soft : world_.soft) constrain(step, soft);
  const bool inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  if (inverted && !began_inverted && halvings < max_halvings) {
    stats_ = before;
    stats_.smallest_h = std::min(stats_.smallest_h, 0.5 * h);
    for (SceneSoftBody& soft : world_.soft) restore_start(soft.body), soft.inverted = false;
    advance(0.5 * h, halvings + 1);
    advance(0.5 * h, halvings + 1);
    return;
  }
  for (SceneSoftBody& soft : world_.soft) finish(step, soft);
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.end_step(); });
}

void Stepper::predict(const Substep& step, SceneSoftBody& soft) {
  if (!soft.forces_valid) evaluate_forces(world_, soft);
  keep_start(soft.body);
  kick(world_, soft, 0.5 * step.h);
  world_.phases.run(Phase::grab, [&] { follow_grab(step, soft); });
  if (soft.implicit)
    world_.phases.run(Phase::implicit_euler, [&] { soft.implicit->predict(soft.body, step.h); });
  else
    world_.phases.run(Phase::symplectic_euler, [&] { drift(soft.body, step.h); });
  world_.phases.run(Phase::pins, [&] { follow_pins(world_, soft); });
}

void Stepper::finish(const Substep& step, SceneSoftBody& soft) {
  if (soft.implicit)
    world_.phases.run(Phase::implicit_euler, [&] { soft.implicit->finish(soft.body, step.h); });
  else
    velocities_from_positions(soft.body, step.h);
  if (soft.contacts) world_.phases.run(Phase::restitution, [&] { soft.contacts->bounce(soft.body, step.h); });
  if (soft.inverted) recover_inverted(step, soft);
  evaluate_forces(world_, soft);
  kick(world_, soft, 0.5 * step.h);
}

}  // namespace isochor
