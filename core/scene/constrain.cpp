#include <algorithm>

#include "core/dynamics/inversion.h"
#include "core/scene/detect_contacts.h"
#include "core/scene/substep.h"

namespace isochor {
namespace {

/// The active set of contacts usually stands after two rounds; later rounds only add to it, so that it ends.
/// What friction still lacks then, the next substep starts from.
constexpr int max_contact_rounds = 14;
constexpr int release_rounds = 4;
/// Largest cell error while the set changes: forces are known to a few per cent then, enough to judge by.
constexpr double rough_tolerance = 1e-3;
/// Distance from its anchor that a substep leaves an attached particle, in cells.
constexpr double attachment_slop = 1e-7;
constexpr int max_lift_rounds = 10;
/// Cells that lifts may move a particle from where it would have gone alone.
constexpr double far_away = 2.0;
constexpr int max_recovery_rounds = 30;
/// Of both, for a start that is inverted.
constexpr int max_start_rounds = 5;
/// Error of a cell after a projection from which no round of contacts or lifts leads back.
constexpr double burst = 1e3;

ProjectionRequest make_request(const Substep& step, SceneSoftBody& soft) {
  ProjectionRequest request;
  request.start = &soft.body.start_positions;
  if (soft.contacts) request.blocked = soft.contacts->blocked();
  request.tolerance = step.tolerance;
  request.max_iterations = step.world.scene.solver.max_iterations;
  request.lifting = soft.recovered;
  return request;
}

ProjectionResult project(const Substep& step, SceneSoftBody& soft, ProjectionRequest request) {
  ProjectionResult result;
  if (soft.contacts) request.blocked_forces = soft.contacts->blocked_forces();
  step.world.phases.run(Phase::volume,
                        [&] { result = soft.body.projector->project(request, soft.body.positions); });
  step.stats.iterations += result.iterations;
  return result;
}

void apply(const Substep& step, std::span<const DueWrench> dues) {
  for (const DueWrench& due : dues)
    step.world.rigid.apply_wrench(due.source, due.center, due.push / step.h, due.moment / step.h);
}

ProjectionResult project_with_contacts(const Substep& step, SceneSoftBody& soft) {
  ParticleContacts& contacts = *soft.contacts;
  ProjectionResult result;
  bool rough = false;
  for (int round = 0; round < max_contact_rounds; ++round) {
    const bool changed = renew_contacts(step, soft, round);
    if (!changed && !rough) break;
    ProjectionRequest request = make_request(step, soft);
    rough = changed && round + 1 < max_contact_rounds && !contacts.empty() && !soft.pressed_implicitly;
    if (rough) request.tolerance = std::max(request.tolerance, rough_tolerance);
    // Last, with the rigid bodies where they are: nothing is left inside them.
    if (round + 1 < max_contact_rounds && !step.held) request.carriers = contacts.carriers();
    result = project(step, soft, request);
    if ((contacts.empty() && round > 0) || has_burst(result)) break;
  }
  contacts.take_forces();
  return result;
}

/// At the end of a projection, which has seen it in most cases.
void find_inverted(const Substep& step, SceneSoftBody& soft, const ProjectionResult& last) {
  step.world.phases.run(Phase::inversion, [&] {
    soft.inverted = last.inverted ? *last.inverted : any_inverted(*soft.body.mesh, soft.body.positions);
  });
}

/// What is between surfaces may have no room: there contacts that let go would throw it out.
bool lies_on_one_surface(const SceneSoftBody& soft) {
  if (!soft.contacts || soft.contacts->empty()) return false;
  const int source = soft.contacts->contacts().front().plane[0].source;
  return std::ranges::all_of(soft.contacts->contacts(), [&](const ParticleContact& contact) {
    return contact.planes == 0 || (contact.planes == 1 && contact.plane[0].source == source);
  });
}

/// Lifts inverted tets, each time followed by contacts and volume; what then still is, the stepper halves the
/// substep for. True when there were any.
template <class Meet>
bool lift_inverted(const Substep& step, SceneSoftBody& soft, const Meet& meet) {
  find_inverted(step, soft, soft.projection);
  if (!soft.inverted || soft.began_inverted || !step.may_lift || has_burst(soft.projection)) return false;
  ++step.stats.recoveries;
  soft.recovered = true;
  for (int round = 0; round < max_lift_rounds && soft.inverted && !has_burst(soft.projection); ++round) {
    step.world.phases.run(Phase::inversion, [&] {
      ProjectionRequest request = make_request(step, soft);
      if (soft.contacts) request.blocked_forces = soft.contacts->blocked_forces();
      soft.tets->lift(soft.body, request, round, lies_on_one_surface(soft), soft.body.positions);
      if (soft.contacts) soft.contacts->take_forces();
    });
    meet();
    find_inverted(step, soft, soft.projection);
  }
  if (!soft.inverted) soft.inverted = throws_a_particle(step, soft.body);
  return true;
}

}  // namespace

bool has_burst(const ProjectionResult& result) {
  return !result.converged && result.max_error > burst;
}

bool throws_a_particle(const Substep& step, const SoftBody& body) {
  const double farthest = far_away * body.cell_size;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) - body.start_positions.at(i);
    if (!((moved - step.h * body.start_velocities.at(i)).norm() <= farthest)) return true;
  }
  return false;
}

bool renew_contacts(const Substep& step, SceneSoftBody& soft, int round) {
  ParticleContacts& contacts = *soft.contacts;
  bool changed = round == 0;
  if (round > 0) {
    step.world.phases.run(Phase::contacts, [&] {
      if (soft.pressed_implicitly)  // friction and release stand already
        contacts.take_forces();
      else
        changed = contacts.update(soft.body, round <= release_rounds) && round <= release_rounds;
    });
    answer(step, soft);
  }
  step.world.phases.run(Phase::contacts, [&] {
    changed |= follow_attachments(step.world, soft);
    changed |= detect_contacts(soft.body, step.world.rigid, step.h, *soft.candidates, contacts);
    if (changed) contacts.place(soft.body);
    if (changed && round + 1 < max_contact_rounds && !step.held)
      contacts.carry(soft.body, step.compliance_of());
  });
  return changed;
}

bool follow_attachments(const World& world, SceneSoftBody& soft) {
  bool moved = false;
  for (const PinnedParticle& held : soft.attachments)
    moved |= soft.contacts->attach(soft.body, held.particle, held.rigid,
                                   world.rigid.predicted_pose(held.rigid).to_world(held.anchor),
                                   attachment_slop * soft.body.cell_size);
  return moved;
}

void answer(const Substep& step, SceneSoftBody& soft) {
  if (step.world.massive.empty()) return;
  step.world.phases.run(Phase::rigid_bodies, [&] {
    hand_out(step, soft);
    step.world.rigid.solve();
  });
}

void hand_out(const Substep& step, SceneSoftBody& soft) {
  apply(step, soft.contacts->take_due(soft.body));
}

namespace {

/// Contacts that no implicit solve balances, in the shortest substep: all that has been done for them is
/// taken back, and what the projection does instead may not add energy.
void let_go(const Substep& step, SceneSoftBody& soft) {
  soft.pressed_implicitly = false;
  soft.recovered = true;
  ++step.stats.recoveries;
  soft.implicit->release(soft.body);
  step.world.phases.run(Phase::rigid_bodies, [&] {
    apply(step, soft.contacts->take_back());
    step.world.rigid.solve();
  });
  step.world.phases.run(Phase::contacts,
                        [&] { soft.contacts->begin(soft.body, step.h, step.world.massive); });
}

void begin_contacts(const Substep& step, SceneSoftBody& soft, std::span<const MassiveBody> massive) {
  if (!soft.contacts) return;
  step.world.phases.run(Phase::contacts, [&] {
    soft.candidates->known = false;
    soft.contacts->begin(soft.body, step.h, massive, soft.pressed_implicitly);
  });
}

void meet(const Substep& step, SceneSoftBody& soft) {
  const auto project_all = [&] {
    soft.projection =
        soft.contacts ? project_with_contacts(step, soft) : project(step, soft, make_request(step, soft));
  };
  project_all();
  lift_inverted(step, soft, project_all);
}

/// A cell whose corners all stick has no row, and keeps what an earlier substep has left of its error.
bool is_left_rough(const SceneSoftBody& soft) {
  const ProjectionResult& result = soft.projection;
  return !result.converged && result.rowless_cells > 0 && result.max_error <= 2.0 * tolerance_within_frames;
}

/// Contacts hold along their normals alone, so that such cells get their volumes all the same.
void slide(const Substep& step, SceneSoftBody& soft) {
  if (soft.contacts) soft.contacts->let_slide(soft.body);
  project_volume(step, soft, step.tolerance);
  if (soft.contacts) soft.contacts->take_forces();
}

}  // namespace

bool constrain_again(const Substep& step, SceneSoftBody& soft) {
  bool changed = false;
  step.world.phases.run(Phase::contacts, [&] {
    changed = follow_attachments(step.world, soft);
    changed |= detect_contacts(soft.body, step.world.rigid, step.h, *soft.candidates, *soft.contacts);
  });
  if (!changed) return false;
  soft.unbalanced = soft.pressed_implicitly && !press_implicitly(step, soft);
  if (!(soft.unbalanced && step.may_halve)) meet(step, soft);
  return true;
}

void constrain(const Substep& step, SceneSoftBody& soft) {
  soft.began_inverted = soft.inverted;
  soft.recovered = false;
  soft.pressed_implicitly = soft.implicit && soft.contacts;
  begin_contacts(step, soft, step.world.massive);
  soft.unbalanced = soft.pressed_implicitly && !press_implicitly(step, soft);
  if (soft.unbalanced && step.may_halve) return;
  if (soft.unbalanced) let_go(step, soft);
  if (!soft.implicit)  // which knows the volume already
    step.world.phases.run(Phase::volume, [&] {
      soft.body.projector->begin_step(soft.body.start_positions, step.h, soft.body.positions);
    });
  meet(step, soft);
  if (is_left_rough(soft) && !soft.inverted) {
    slide(step, soft);
    find_inverted(step, soft, soft.projection);
  }
  // What the projection had to move against stiff springs.
  if (soft.pressed_implicitly && step.may_halve) soft.unbalanced = gains_energy(step, soft);
}

void bring_to_volume(const Substep& step, SceneSoftBody& soft) {
  keep_start(soft.body);
  soft.began_inverted = soft.inverted;
  soft.recovered = soft.pressed_implicitly = false;
  begin_contacts(step, soft, {});
  meet(step, soft);
  for (int round = 0; round < max_start_rounds && soft.inverted; ++round) {
    recover_inverted(step, soft);
    keep_start(soft.body);
    begin_contacts(step, soft, {});
    meet(step, soft);
  }
  soft.forces_valid = false;
}

void project_volume(const Substep& step, SceneSoftBody& soft, double tolerance) {
  ProjectionRequest request = make_request(step, soft);
  request.tolerance = tolerance;
  if (soft.contacts) request.carriers = soft.contacts->carriers();
  const bool kept_directions = soft.projection.kept_directions;
  soft.projection = project(step, soft, request);
  soft.projection.kept_directions &= kept_directions;
}

void refine_volume(const Substep& step, SceneSoftBody& soft) {
  // Of where it was left: the last projection may be one that was taken back.
  if (soft.inverted || volume_errors(soft.body).max_cell_error > 2.0 * tolerance_within_frames) return;
  keep_start(soft.body);
  slide(step, soft);
  find_inverted(step, soft, soft.projection);
  if (soft.inverted) restore_start(soft.body);
  soft.inverted = soft.forces_valid = false;
}

bool lift_inverted(const Substep& step, SceneSoftBody& soft) {
  soft.projection.inverted.reset();  // contacts have moved the body since
  return lift_inverted(step, soft, [&] {
    project_volume(step, soft, step.tolerance);
    if (soft.contacts) soft.contacts->take_forces();
  });
}

void record_projection(const Substep& step, const SceneSoftBody& soft) {
  StepStats& stats = step.stats;
  const ProjectionResult& result = soft.projection;
  if (!result.kept_directions) ++stats.fallbacks;
  if (result.converged) return;
  stats.feasible = false;
  if (result.max_error < stats.worst_error) return;
  stats.worst_error = result.max_error;
  stats.worst_body = soft.id;
  stats.worst_cell = result.worst_cell;
}

void recover_inverted(const Substep& step, SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  ProjectionRequest request = make_request(step, soft);
  request.start = nullptr;
  ++step.stats.recoveries;
  soft.recovered = true;
  soft.forces_valid = false;
  for (int round = 0; round < max_recovery_rounds && soft.inverted; ++round) {
    step.world.phases.run(Phase::inversion, [&] {
      pull_flattened_cells(body, body.positions);
      soft.tets->lift(body, request, 0, false, body.positions);
    });
    find_inverted(step, soft, project(step, soft, request));
  }
  if (!soft.began_inverted) soft.inverted |= throws_a_particle(step, body);
}

}  // namespace isochor
