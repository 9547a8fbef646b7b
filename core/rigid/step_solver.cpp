#include "core/rigid/step_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace isochor {
namespace {

constexpr double position_tolerance = 1e-10;  // metres (radians) left at the end of a step
constexpr double closed_gap = 1e-7;           // metres: contacts that near take part in the velocities' stage
constexpr double slop = 1e-6;                 // metres: bodies that near touch
constexpr double turn_a_step = 0.15, swing_a_step = 0.5;  // radians, of rotation and of phase
constexpr int max_newton_rounds = 30, max_completions = 8;
/// So many rounds that gain nothing are the last: contacts that oppose each other leave no way out.
constexpr int patience = 8;

double rate(const ConstraintRow& row, std::span<const BodyRecord> bodies) {
  const BodyRecord &a = bodies[index(row.a)], &b = bodies[index(row.b)];
  return row.impulse_on.linear.dot(a.velocity() - b.velocity()) +
         row.impulse_on.angular_a.dot(a.angular_velocity()) -
         row.impulse_on.angular_b.dot(b.angular_velocity());
}

}  // namespace

void StepSolver::add_joint(const RigidJoint& joint) {
  joints_.push_back(joint);
  jointed_.push_back(std::minmax(joint.a, joint.b));
  std::sort(jointed_.begin(), jointed_.end());
}

/// A joint under the force F swings a body about it as a pendulum does: ω² = F·r/(I + m·r²) at most, with its
/// parts F·r/I and F/(m·r) the ones that a light body or a short arm make large.
double StepSolver::fastest_rate(std::span<const BodyRecord> bodies) const {
  double fastest = 0.0;
  for (const RigidJoint& joint : joints_) {
    const Vec3 impulse(joint.impulses[0], joint.impulses[1], joint.impulses[2]);
    const double force = last_h_ > 0.0 ? 2.0 * impulse.norm() / last_h_ : 0.0;
    for (const auto& [index_of, anchor] :
         {std::pair(joint.a, &joint.anchor_a), std::pair(joint.b, &joint.anchor_b)}) {
      const BodyRecord& body = bodies[index(index_of)];
      if (!body.dynamic()) continue;
      const double swing = std::sqrt(force * anchor->norm() * body.state.inverse_inertia.trace());
      fastest = std::max({fastest, body.angular_velocity().norm() / turn_a_step, swing / swing_a_step});
    }
  }
  return fastest;
}

void StepSolver::list_pairs(std::vector<BodyPair>& pairs) const {
  pairs.insert(pairs.end(), jointed_.begin(), jointed_.end());
  for (const RigidContact& contact : found_.contacts) pairs.emplace_back(contact.a, contact.b);
}

void StepSolver::begin(std::span<BodyRecord> bodies, const Vec3& gravity, double h) {
  h_ = h;
  metrics_ = {};
  lost_.resize(bodies.size());
  const auto counts = [&](int a, int b) {
    return last_h_ > 0.0 && !any_lost(a, b) ? std::min(1.0, h / last_h_) : 0.0;
  };
  found_.begin({bodies, joints_, gravity, h, slop}, jointed_);
  for (RigidContact& contact : found_.contacts) {
    const BodyRecord &a = bodies[index(contact.a)], &b = bodies[index(contact.b)];
    const Vec3 normal = contact_normal(contact, a.state.pose, b.state.pose);
    const Vec3 arm_a = a.state.pose.orientation * contact.local_a - contact.radius_a * normal;
    const Vec3 arm_b = b.state.pose.orientation * contact.local_b + contact.radius_b * normal;
    contact.approach = -normal.dot(a.velocity() + a.angular_velocity().cross(arm_a) - b.velocity() -
                                   b.angular_velocity().cross(arm_b));
    if (contact.approach <= 2.0 * h * gravity.norm()) contact.approach = 0.0;  // resting
    contact.impulse *= counts(contact.a, contact.b);
  }
  for (RigidJoint& joint : joints_)
    for (double& impulse : joint.impulses) impulse *= counts(joint.a, joint.b);
  for (BodyRecord& body : bodies)
    if (body.dynamic()) body.state.velocity += 0.5 * h * gravity;
  std::ranges::fill(lost_, 0);
  build_rows(bodies);
  warm_start(bodies, Stage::positions);
}

/// Inverse inertias at that part of the way from the present to the predicted orientations.
void StepSolver::load_bodies(std::span<const BodyRecord> bodies, double part) {
  solver_bodies_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    RigidBodyState at = bodies[i].state;
    if (part > 0.0 && at.dynamic())
      at.pose.orientation = at.pose.orientation.slerp(part, predicted_[i].orientation);
    solver_bodies_.push_back({at.inverse_mass, at.world_inverse_inertia()});
  }
}

/// What the rows' impulses amount to, for impulses that the bodies do not have yet.
void StepSolver::give_impulses(std::span<BodyRecord> bodies) {
  for (const ConstraintRow& row : set_.rows) {
    SolverBody &a = solver_bodies_[index(row.a)], &b = solver_bodies_[index(row.b)];
    a.impulse += row.impulse * row.impulse_on.linear;
    a.angular_impulse += row.impulse * row.impulse_on.angular_a;
    b.impulse -= row.impulse * row.impulse_on.linear;
    b.angular_impulse -= row.impulse * row.impulse_on.angular_b;
  }
  apply_gathered(bodies);
}

void StepSolver::apply_gathered(std::span<BodyRecord> bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    SolverBody& gathered = solver_bodies_[i];
    if (bodies[i].dynamic()) {
      bodies[i].state.velocity += gathered.inverse_mass * gathered.impulse;
      bodies[i].state.angular_momentum += gathered.angular_impulse;
    }
    gathered.impulse = gathered.angular_impulse = Vec3::Zero();
  }
}

void StepSolver::predict(std::span<const BodyRecord> bodies) {
  predicted_.clear();
  for (const BodyRecord& body : bodies) predicted_.push_back(body.predicted(h_));
}

void StepSolver::add_contact_rows(const RigidContact& contact, std::span<const BodyRecord> bodies) {
  append_contact_rows(contact, bodies[index(contact.a)].state.pose, bodies[index(contact.b)].state.pose,
                      set_);
  ConstraintRow* rows = &set_.rows[set_.rows.size() - 3];
  for (int i = 0; i < 3; ++i) rows[i].impulse = rows[i].impulse_on.linear.dot(contact.impulse);
  rows[0].impulse = std::max(0.0, rows[0].impulse);
}

void StepSolver::build_rows(std::span<const BodyRecord> bodies) {
  load_bodies(bodies, 0.0);
  set_.clear();
  for (const RigidJoint& joint : joints_) {
    append_joint_rows(joint, bodies[index(joint.a)].state.pose, bodies[index(joint.b)].state.pose, set_);
    for (int i = 0; i < joint.rows(); ++i)
      (set_.rows.end() - joint.rows() + i)->impulse = joint.impulses[index(i)];
  }
  for (const RigidContact& contact : found_.contacts) add_contact_rows(contact, bodies);
  for (ConstraintBlock& block : set_.blocks) {
    ConstraintRow* rows = &set_.rows[index(block.first)];
    block.idle = any_lost(rows->a, rows->b);
    for (int i = 0; block.idle && i < block.count; ++i) rows[i].impulse = 0.0;
  }
  solver_.prepare(set_, solver_bodies_);
}

/// Errors of the predicted poses over h for joints and normals, rates for friction.
void StepSolver::position_residuals(std::span<const BodyRecord> bodies) {
  auto row = set_.rows.begin();
  std::array<double, 6> error{};
  for (const RigidJoint& joint : joints_) {
    joint_errors(joint, predicted_[index(joint.a)], predicted_[index(joint.b)], {&*row, index(joint.rows())},
                 error);
    for (int i = 0; i < joint.rows(); ++i, ++row) row->residual = error[index(i)] / h_;
  }
  for (const RigidContact& contact : found_.contacts) {
    const double gap = contact_gap(contact, predicted_[index(contact.a)], predicted_[index(contact.b)]);
    row->residual = (gap - contact.least_gap) / h_;
    for (int tangent = 1; tangent < 3; ++tangent) row[tangent].residual = rate(row[tangent], bodies);
    row += 3;
  }
}

double StepSolver::violation(std::span<const BodyRecord> bodies, Stage stage) {
  if (stage == Stage::positions) {
    predict(bodies);
    position_residuals(bodies);
  } else {
    velocity_residuals(bodies);
  }
  return solver_.violation(set_);
}

/// Gives the last impulses at once, unless the step is better off without.
void StepSolver::warm_start(std::span<BodyRecord> bodies, Stage stage) {
  last_impulses_.clear();
  for (ConstraintRow& row : set_.rows) last_impulses_.push_back(std::exchange(row.impulse, 0.0));
  const double cold = violation(bodies, stage);
  remember(bodies);
  for (std::size_t i = 0; i < set_.rows.size(); ++i) set_.rows[i].impulse = last_impulses_[i];
  give_impulses(bodies);
  if (!(violation(bodies, stage) < cold)) recall(bodies);
}

/// Contacts that leave no way out press against each other without end: the group of bodies that is farthest
/// from a solution is given up for this step, and the others are solved without it.
void StepSolver::newton(std::span<BodyRecord> bodies, Stage stage) {
  while (!(iterate(bodies, stage) * h_ <= slop)) give_up_worst(bodies, stage);
}

/// Returns the violation of the best round, with which it ends.
double StepSolver::iterate(std::span<BodyRecord> bodies, Stage stage) {
  const double tolerance = position_tolerance / h_;
  keep_velocities(bodies, entry_);
  keep_impulses(entry_impulses_);
  double best = 1e300;
  int in_vain = 0;
  for (int round = 0; round <= max_newton_rounds; ++round) {
    const double left = violation(bodies, stage);
    in_vain = left < 0.99 * best ? 0 : in_vain + 1;
    if (left < best) best = left, remember(bodies);
    if (left <= tolerance) return left;
    if (round == max_newton_rounds || in_vain == patience || !(left < 1e3 * best)) break;
    ++metrics_.iterations;
    if (stage == Stage::positions) {
      load_bodies(bodies, 0.5);
      solver_.prepare(set_, solver_bodies_);
    }
    solver_.solve(set_, solver_bodies_, std::max(0.1 * tolerance, 1e-4 * left));
    apply_gathered(bodies);
  }
  metrics_.converged = false;
  recall(bodies);
  return best;
}

void StepSolver::give_up_worst(std::span<BodyRecord> bodies, Stage stage) {
  violation(bodies, stage);
  find_groups(bodies);
  const ConstraintBlock* worst = nullptr;
  double most = 0.0;
  for (const ConstraintBlock& block : set_.blocks) {
    if (block.idle) continue;
    const double violated = solver_.violation(set_, block);
    if (!worst || !(violated <= most)) worst = &block, most = violated;
  }
  const int group = group_of(*worst, bodies);
  limit_energy(bodies, group);
  metrics_.gave_up |= std::ranges::any_of(found_.contacts, [&](const RigidContact& contact) {
    return group_of(contact.a, contact.b, bodies) == group &&
           contact_gap(contact, bodies[index(contact.a)].state.pose, bodies[index(contact.b)].state.pose) <
               -slop;
  });
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (groups_.root(static_cast<int>(i)) == group) {
      lost_[i] = 1;
    } else {
      bodies[i].state.velocity = entry_[i][0];
      bodies[i].state.angular_momentum = entry_[i][1];
    }
  }
  for (ConstraintBlock& block : set_.blocks) {
    if (group_of(block, bodies) == group)
      block.idle = true;
    else
      for (int i = block.first; i < block.first + block.count; ++i)
        set_.rows[index(i)].impulse = entry_impulses_[index(i)];
  }
}

void StepSolver::find_groups(std::span<const BodyRecord> bodies) {
  groups_.reset(bodies.size());
  for (const ConstraintRow& row : set_.rows)
    if (bodies[index(row.a)].dynamic() && bodies[index(row.b)].dynamic()) groups_.join(row.a, row.b);
}

/// Of two that touch or are jointed: that of a dynamic one.
int StepSolver::group_of(int a, int b, std::span<const BodyRecord> bodies) const {
  return groups_.root(bodies[index(a)].dynamic() ? a : b);
}

int StepSolver::group_of(const ConstraintBlock& block, std::span<const BodyRecord> bodies) const {
  const ConstraintRow& row = set_.rows[index(block.first)];
  return group_of(row.a, row.b, bodies);
}

/// Of what its impulses have given as much stays as adds no energy, or no more than takes the bodies out of
/// each other or along with what moves by itself. Momentum is kept.
void StepSolver::limit_energy(std::span<BodyRecord> bodies, int group) {
  const auto speed_of = [](const BodyRecord& body, const Vec3& local) {
    return body.dynamic() ? 0.0 : body.velocity().norm() + body.angular_velocity().norm() * local.norm();
  };
  double speed = 0.0, before = 0.0, after = 0.0, change = 0.0, allowed = 0.0;
  for (const RigidContact& contact : found_.contacts) {
    const BodyRecord &a = bodies[index(contact.a)], &b = bodies[index(contact.b)];
    if (group_of(contact.a, contact.b, bodies) != group) continue;
    const double depth = std::max(0.0, -contact_gap(contact, a.state.pose, b.state.pose));
    speed =
        std::max(speed, emerging_rate * depth + speed_of(a, contact.local_a) + speed_of(b, contact.local_b));
  }
  const auto energy_of = [&](std::size_t i, const std::array<Vec3, 2>& velocities) {
    RigidBodyState state = bodies[i].state;
    state.velocity = velocities[0];
    state.angular_momentum = velocities[1];
    return kinetic_energy(state);
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (groups_.root(static_cast<int>(i)) != group || !bodies[i].dynamic()) continue;
    const std::array<Vec3, 2> given{best_velocities_[i][0] - entry_[i][0],
                                    best_velocities_[i][1] - entry_[i][1]};
    before += energy_of(i, entry_[i]);
    after += energy_of(i, best_velocities_[i]);
    change += energy_of(i, given);
    allowed += 0.5 * bodies[i].mass * speed * speed;
  }
  allowed = std::max(allowed, before);
  if (!(after > allowed) || !(change > 0.0)) return;
  // before + b·part + change·part² = allowed
  const double b = after - before - change;
  const double part =
      std::clamp((-b + std::sqrt(b * b + 4.0 * change * (allowed - before))) / (2.0 * change), 0.0, 1.0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (groups_.root(static_cast<int>(i)) != group || !bodies[i].dynamic()) continue;
    bodies[i].state.velocity = entry_[i][0] + part * (best_velocities_[i][0] - entry_[i][0]);
    bodies[i].state.angular_momentum = entry_[i][1] + part * (best_velocities_[i][1] - entry_[i][1]);
  }
  for (const ConstraintBlock& block : set_.blocks)
    if (group_of(block, bodies) == group)
      for (int i = block.first; i < block.first + block.count; ++i)
        set_.rows[index(i)].impulse =
            entry_impulses_[index(i)] + part * (best_impulses_[index(i)] - entry_impulses_[index(i)]);
}

void StepSolver::keep_impulses(std::vector<double>& impulses) const {
  impulses.clear();
  for (const ConstraintRow& row : set_.rows) impulses.push_back(row.impulse);
}

void StepSolver::keep_velocities(std::span<const BodyRecord> bodies,
                                 std::vector<std::array<Vec3, 2>>& velocities) {
  velocities.clear();
  for (const BodyRecord& body : bodies)
    velocities.push_back({body.state.velocity, body.state.angular_momentum});
}

/// The best velocities and impulses so far: a step that does not converge ends with these.
void StepSolver::remember(std::span<const BodyRecord> bodies) {
  keep_velocities(bodies, best_velocities_);
  keep_impulses(best_impulses_);
}

void StepSolver::recall(std::span<BodyRecord> bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].state.velocity = best_velocities_[i][0];
    bodies[i].state.angular_momentum = best_velocities_[i][1];
  }
  for (std::size_t i = 0; i < set_.rows.size(); ++i) set_.rows[i].impulse = best_impulses_[i];
}

void StepSolver::solve_positions(std::span<BodyRecord> bodies) {
  for (int completion = 0; completion < max_completions; ++completion) {
    newton(bodies, Stage::positions);
    predict(bodies);
    store_impulses();
    if (!found_.complete({bodies, joints_, Vec3::Zero(), h_, slop}, predicted_)) return;
    build_rows(bodies);
  }
}

void StepSolver::weigh(std::span<const BodyRecord> bodies) {
  predict(bodies);
  load_bodies(bodies, 0.5);
  solver_.prepare(set_, solver_bodies_);
}

Eigen::Matrix<double, 6, 6> StepSolver::compliance(int body) {
  Eigen::Matrix<double, 6, 6> result;
  solver_.hold(set_, solver_bodies_);
  SolverBody& pushed = solver_bodies_[index(body)];
  for (int direction = 0; direction < 6; ++direction) {
    (direction < 3 ? pushed.impulse : pushed.angular_impulse)[direction % 3] = 1.0;
    solver_.respond(solver_bodies_);
    result.col(direction) << pushed.inverse_mass * pushed.impulse,
        pushed.inverse_inertia * pushed.angular_impulse;
    for (SolverBody& b : solver_bodies_) b.impulse = b.angular_impulse = Vec3::Zero();
  }
  return 0.5 * (result + result.transpose());
}

void StepSolver::velocity_residuals(std::span<const BodyRecord> bodies) {
  for (ConstraintRow& row : set_.rows) row.residual = rate(row, bodies);
  std::size_t normal = set_.rows.size() - 3 * found_.contacts.size();
  for (const RigidContact& contact : found_.contacts) {
    set_.rows[normal].residual -= contact.restitution * contact.approach;
    normal += 3;
  }
}

void StepSolver::solve_velocities(std::span<BodyRecord> bodies) {
  for (RigidContact& contact : found_.contacts) {
    if (contact.impulse.isZero(0.0)) contact.approach = 0.0;  // did not meet
    if (any_lost(contact.a, contact.b)) found_.leave_within(pair_of(contact));
  }
  found_.renew({bodies, joints_, Vec3::Zero(), h_, slop}, closed_gap);
  build_rows(bodies);
  warm_start(bodies, Stage::velocities);
  newton(bodies, Stage::velocities);
  store_impulses();
  measure(bodies);
  last_h_ = h_;
}

void StepSolver::store_impulses() {
  auto row = set_.rows.begin();
  for (RigidJoint& joint : joints_)
    for (int i = 0; i < joint.rows(); ++i, ++row) joint.impulses[index(i)] = row->impulse;
  for (RigidContact& contact : found_.contacts) {
    contact.impulse = Vec3::Zero();
    for (int direction = 0; direction < 3; ++direction, ++row)
      contact.impulse += row->impulse * row->impulse_on.linear;
  }
}

void StepSolver::measure(std::span<const BodyRecord> bodies) {
  std::array<double, 6> error{};
  auto row = set_.rows.begin();
  for (const RigidJoint& joint : joints_) {
    joint_errors(joint, bodies[index(joint.a)].state.pose, bodies[index(joint.b)].state.pose,
                 {&*row, index(joint.rows())}, error);
    for (int i = 0; i < joint.rows(); ++i, ++row)
      metrics_.max_joint_error = std::max(metrics_.max_joint_error, std::abs(error[index(i)]));
  }
  for (const RigidContact& contact : found_.contacts) {
    const double gap =
        contact_gap(contact, bodies[index(contact.a)].state.pose, bodies[index(contact.b)].state.pose);
    metrics_.max_penetration = std::max(metrics_.max_penetration, -gap);
    if (!contact.impulse.isZero(0.0)) ++metrics_.contacts;
  }
}

}  // namespace isochor
