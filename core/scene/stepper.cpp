#include "core/scene/stepper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/dynamics/rigid_part.h"
#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

constexpr int max_halvings = 5;
/// s; what comes out of rigid bodies before the first frame takes as long as it needs.
constexpr double at_leisure = 1e6;
/// At most so many times what the frame asks for; who asks for less than this wants the path itself.
constexpr double slack_within_frames = 100.0, finest_of_a_frame = 1e-7;
/// Cells a substep: what is faster meets things so hard that every substep has to be exact.
constexpr double gentle = 0.25;
/// What is left of a cell's error makes speeds of error·cell/h: so much of the body's largest at most.
constexpr double noise = 0.01;
/// Beyond so many substeps a frame cells are kept to so much, whatever is asked: at 354 an error of 1e-3
/// makes a speed of 3 m/s in cells of 0.15 m, for which a third of the substeps of a stack were taken back.
constexpr int many_substeps = 60;
constexpr double tolerance_of_many = 1e-5;

ImplicitScheme scheme_of(SpringIntegrator integrator) {
  return integrator == SpringIntegrator::energy_momentum ? ImplicitScheme::energy_momentum
                                                         : ImplicitScheme::euler;
}

bool is_in_free_flight(const SceneSoftBody& soft) {
  return soft.attachments.empty() && !soft.touched && (!soft.contacts || soft.contacts->empty());
}

/// Bodies that touch are stepped by implicit Euler, all of them together.
bool touches_filtered(const SceneSoftBody& soft) {
  return soft.touched && soft.stepping == SpringIntegrator::energy_momentum;
}

/// Implicit Euler knows no forces at the end of a substep, so that gravity alone would move what pins and
/// contacts hold: its second half kick then waits for the next substep. Positions are the same.
/// Not where bodies with a mass hold it, whose momentum counts at the end of every substep.
bool is_held(const World& world, const SceneSoftBody& soft) {
  return soft.stepping == SpringIntegrator::implicit &&
         (soft.body.has_pins || (world.massive.empty() && !is_in_free_flight(soft)));
}

/// Particles have moved, and their velocities have another angular momentum about the centre now.
void keep_turning(const Vec3& angular_momentum, SoftBody& body) {
  if (body.has_pins) return;
  const Coordinates& x = body.positions;
  const Vec3 center = mass_center(body, x);
  const Vec3 spin = spin_of(body, x, angular_momentum - moment(body, x, body.velocities));
  for (std::size_t i = 0; i < body.size(); ++i) body.velocities.add(i, spin.cross(x.at(i) - center));
}

}  // namespace

Stepper::Stepper(World& world) : world_(world), guard_(world) {
  for (SceneSoftBody& soft : world_.soft) soft.inverted = any_inverted(*soft.body.mesh, soft.body.positions);
}

StepStats Stepper::frame(double seconds, const Progress& progress) {
  stats_ = StepStats{};
  const double h = seconds / world_.substeps, asked = asked_tolerance();
  stats_.smallest_h = h;
  bool rough = false;
  begin_at_ = 0;
  start();
  for (int s = 0; s < world_.substeps; ++s) {
    progress.throw_if_cancelled();
    tolerance_ = s + 1 < world_.substeps ? tolerance_within_frame(h) : asked;
    rough |= tolerance_ > asked;
    if (world_.soft.empty())
      advance_rigid(h);
    else
      advance_jointed(h);
  }
  for (SceneSoftBody& soft : world_.soft)
    if (rough && soft.halts_in_a_row > 0) refine_volume({world_, stats_, h, asked}, soft);
  return stats_;
}

// In a substep they would make speeds of error·cell/h: a cube stretched by 5 % had 60 times its energy.
void Stepper::start() {
  Substep step{world_, stats_, at_leisure, asked_tolerance()};
  step.held = true;
  for (SceneSoftBody& soft : world_.soft) {
    if (std::exchange(soft.started, true)) continue;
    if (!soft.inverted && volume_errors(soft.body).max_cell_error <= step.tolerance) continue;
    const Vec3 turning = moment(soft.body, soft.body.positions, soft.body.velocities);
    if (soft.inverted && turn_right_side_out(soft.body, soft.body.positions))
      soft.inverted = any_inverted(*soft.body.mesh, soft.body.positions);
    bring_to_volume(step, soft);
    keep_turning(turning, soft.body);
    soft.energy_ledger = total_energy(soft.body, world_.scene.gravity);
  }
}

double Stepper::asked_tolerance() const {
  const double asked = world_.scene.solver.tolerance;
  return world_.substeps > many_substeps ? std::min(asked, tolerance_of_many) : asked;
}

double Stepper::tolerance_within_frame(double h) const {
  const double asked = asked_tolerance();
  if (asked < finest_of_a_frame) return asked;
  double tolerance = std::min(slack_within_frames * asked, tolerance_within_frames);
  for (const SceneSoftBody& soft : world_.soft) {
    const Coordinates& v = soft.body.velocities;
    double fastest = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i)
      fastest = std::max(fastest, v.x[i] * v.x[i] + v.y[i] * v.y[i] + v.z[i] * v.z[i]);
    const double cells = h * std::sqrt(fastest) / soft.body.cell_size;
    if (soft.implicit || soft.halts_in_a_row > 0 || !(cells <= gentle)) return asked;
    tolerance = std::min(tolerance, noise * cells);
  }
  return std::max(asked, tolerance);
}

void Stepper::advance_rigid(double h) {
  int parts = 1;
  world_.phases.run(Phase::rigid_bodies, [&] { parts = world_.rigid.step(h); });
  stats_.substeps += parts;
  stats_.smallest_h = std::min(stats_.smallest_h, h / parts);
}

void Stepper::advance_jointed(double h) {
  const int parts = world_.rigid.substeps_for(h);
  stats_.smallest_h = std::min(stats_.smallest_h, h / parts);
  for (int part = 0; part < parts; ++part) {
    deepest_ = 0;
    advance(h / parts, 0);
    const bool helped = std::ranges::none_of(
        world_.soft, [](const SceneSoftBody& soft) { return soft.inverted || soft.halts_in_a_row > 0; });
    begin_at_ = !helped ? 0 : deepest_ > begin_at_ ? deepest_ : std::max(begin_at_ - 1, 0);
  }
}

void Stepper::advance_halves(double h, int halvings) {
  stats_.smallest_h = std::min(stats_.smallest_h, 0.5 * h);
  advance(0.5 * h, halvings + 1);
  advance(0.5 * h, halvings + 1);
}

void Stepper::start_rigid(double h) {
  world_.rigid.keep_start();
  world_.rigid.begin_step(h);
  list_massive(world_);
  world_.rigid.solve();
}

void Stepper::advance(double h, int halvings) {
  if (halvings < begin_at_) return advance_halves(h, halvings);
  const bool may_halve = std::ranges::all_of(world_.soft, [&](const SceneSoftBody& soft) {
    return halvings + soft.halts_in_a_row < max_halvings;  // parts that were all taken back helped nothing
  });
  Substep step{world_, stats_, h, tolerance_, may_halve, lifting_};
  const bool began_inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  const StepStats before = stats_;
  ++stats_.substeps;
  guard_.begin();
  world_.phases.run(Phase::rigid_bodies, [&] { start_rigid(h); });
  for (SceneSoftBody& soft : world_.soft) predict(step, soft);
  if (world_.surfaces) begin_collision(step);
  constrain_in_turns(step);
  bool unbalanced = std::ranges::any_of(world_.soft, &SceneSoftBody::unbalanced);
  if (world_.surfaces && !(unbalanced && step.may_halve)) unbalanced |= !collide(step);
  const bool inverted = std::ranges::any_of(world_.soft, &SceneSoftBody::inverted);
  if (((inverted && !began_inverted) || unbalanced) && step.may_halve) {
    take_back(before);
    if (inverted) deepest_ = std::max(deepest_, halvings + 1);
    return advance_halves(h, halvings);
  }
  bool* turned = nullptr;
  if (lifting_ && inverted && !began_inverted)
    turned = &lifting_;
  else if (!together_ && std::ranges::any_of(world_.soft, touches_filtered))
    turned = &together_;
  if (turned) {
    take_back(before);
    *turned = !*turned;
    advance(h, halvings);
    *turned = !*turned;
    return;
  }
  for (SceneSoftBody& soft : world_.soft) soft.finished = settle(step, soft);
  world_.phases.run(Phase::rigid_bodies, [&] {
    world_.rigid.move();
    world_.rigid.put_down();
  });
  for (SceneSoftBody& soft : world_.soft)
    if (!soft.finished) take_velocities(step, soft);
  if (world_.surfaces) world_.phases.run(Phase::restitution, [&] { world_.surfaces->contacts().bounce(); });
  guard_.find_groups();
  for (std::size_t s = 0; s < world_.soft.size(); ++s)
    if (!world_.soft[s].finished) finish(step, s);
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.end_step(); });
  guard_.hold(step);
  remember_contacts();
  count_contacts();
}

void Stepper::remember_contacts() {
  const auto halted = [](const SceneSoftBody& soft) { return soft.halts_in_a_row > 0; };
  for (SceneSoftBody& soft : world_.soft)
    if (soft.contacts && !halted(soft)) soft.contacts->remember();  // else what pressed led nowhere
  if (world_.surfaces && std::ranges::none_of(world_.soft, halted)) world_.surfaces->contacts().remember();
}

void Stepper::count_contacts() {
  stats_.contacts = world_.surfaces ? std::ssize(world_.surfaces->contacts().contacts()) : 0;
  for (const SceneSoftBody& soft : world_.soft)
    if (soft.contacts) stats_.contacts += soft.contacts->count();
}

void Stepper::take_back(const StepStats& before) {
  stats_ = before;
  for (SceneSoftBody& soft : world_.soft) {
    restore_start(soft.body);
    soft.inverted = soft.began_inverted && any_inverted(*soft.body.mesh, soft.body.positions);
  }
  world_.phases.run(Phase::rigid_bodies, [&] { world_.rigid.restore_start(); });
}

void Stepper::predict(const Substep& step, SceneSoftBody& soft) {
  soft.stepping = soft.integrator;
  if (soft.integrator == SpringIntegrator::energy_momentum && (together_ || !is_in_free_flight(soft)))
    soft.stepping = SpringIntegrator::implicit;
  if (!soft.forces_valid) evaluate_forces(world_, soft);
  keep_start(soft.body);
  move_freely(step, soft);
}

void Stepper::move_freely(const Substep& step, SceneSoftBody& soft) {
  kick(world_, soft, 0.5 * step.h + soft.kick_due);
  if (soft.contacts) soft.contacts->give_back(soft.body);
  world_.phases.run(Phase::grab, [&] { follow_grab(step, soft); });
  world_.phases.run(stepping_phase(soft), [&] {
    if (soft.implicit)
      soft.implicit->begin(soft.body, step.h, scheme_of(soft.stepping));
    else
      drift(soft.body, step.h);
  });
  world_.phases.run(Phase::pins, [&] { follow_pins(world_, soft); });
  if (soft.implicit) world_.phases.run(stepping_phase(soft), [&] { soft.implicit->solve(soft.body); });
}

bool Stepper::settle(const Substep& step, SceneSoftBody& soft) {
  if (soft.stepping != SpringIntegrator::energy_momentum) return false;
  if (is_in_free_flight(soft)) {
    const double due = soft.kick_due;
    take_velocities(step, soft);
    finish(step, static_cast<std::size_t>(&soft - world_.soft.data()));
    if (keep_ledger(world_, soft)) return true;
    soft.kick_due = due;
  }
  restore_start(soft.body);
  soft.inverted = false;
  soft.stepping = SpringIntegrator::implicit;
  soft.forces_valid = false;
  move_freely(step, soft);
  constrain({step.world, step.stats, step.h, step.tolerance}, soft);
  return false;
}

void Stepper::take_velocities(const Substep& step, SceneSoftBody& soft) {
  const bool shares_momentum =
      soft.contacts && !soft.contacts->empty() && !world_.massive.empty() && !world_.surfaces;
  if (soft.implicit && shares_momentum)
    soft.implicit->finish(soft.body, step.h, soft.contacts->push(soft.body));
  else if (soft.implicit)
    soft.implicit->finish(soft.body, step.h);
  else
    velocities_from_positions(soft.body, step.h);
  record_projection(step, soft);
}

void Stepper::finish(const Substep& step, std::size_t index) {
  SceneSoftBody& soft = world_.soft[index];
  if (soft.contacts) {
    hand_out(step, soft);
    world_.phases.run(Phase::restitution, [&] {
      for (const DueWrench& due : soft.contacts->bounce(soft.body, step.h))
        world_.rigid.apply_wrench(due.source, due.center, due.push, due.moment);
    });
  }
  if (soft.inverted && !guard_.can_halt(index)) recover_inverted(step, soft);
  evaluate_forces(world_, soft);
  soft.kick_due = is_held(world_, soft) ? 0.5 * step.h : 0.0;
  kick(world_, soft, 0.5 * step.h - soft.kick_due);
  if (soft.contacts) soft.contacts->hold_back(soft.body, 0.5 * step.h - soft.kick_due, world_.scene.gravity);
  if (soft.stepping == soft.integrator) return;
  soft.forces_valid = false;
  if (!is_in_free_flight(soft))  // moving bodies may have put energy in
    soft.energy_ledger = std::max(soft.energy_ledger, total_energy(soft.body, world_.scene.gravity));
}

}  // namespace isochor
