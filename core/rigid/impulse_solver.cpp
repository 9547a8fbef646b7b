#include "core/rigid/impulse_solver.h"

#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

constexpr int sweeps_a_round = 5, max_rounds = 20;

/// Impulses of a contact's normal and tangents that its own rates ask for, others kept. The tangents share
/// one inverse mass so that the clamp onto the cone keeps the direction of sliding.
struct ContactImpulses {
  double normal, tangent1, tangent2;
};
double tangent_inverse_mass(const ConstraintRow* rows) {
  return std::max(rows[1].inverse_mass, rows[2].inverse_mass);
}
double pressed(const ConstraintRow& normal, double rate) {
  return std::max(0.0, normal.impulse - rate / normal.inverse_mass);
}
void rubbed(const ConstraintRow* rows, double rate1, double rate2, double limit, ContactImpulses& result) {
  const double k = tangent_inverse_mass(rows);
  result.tangent1 = rows[1].impulse - rate1 / k;
  result.tangent2 = rows[2].impulse - rate2 / k;
  const double length = Eigen::Vector2d(result.tangent1, result.tangent2).norm();
  if (length <= limit) return;
  result.tangent1 *= limit / length;
  result.tangent2 *= limit / length;
}

double rubbing_change(const ConstraintRow* rows, const ContactImpulses& next) {
  const Eigen::Vector2d change(next.tangent1 - rows[1].impulse, next.tangent2 - rows[2].impulse);
  return tangent_inverse_mass(rows) * change.norm();
}

double sweep_contact(ConstraintRow* rows, double friction, std::span<SolverBody> bodies) {
  ContactImpulses next{};
  next.normal = pressed(rows[0], present_rate(rows[0], bodies));
  double change = std::abs(next.normal - rows[0].impulse) * rows[0].inverse_mass;
  give(rows[0], next.normal - rows[0].impulse, bodies);
  if (friction == 0.0) return change;
  rubbed(rows, present_rate(rows[1], bodies), present_rate(rows[2], bodies), friction * next.normal, next);
  change = std::max(change, rubbing_change(rows, next));
  give(rows[1], next.tangent1 - rows[1].impulse, bodies);
  give(rows[2], next.tangent2 - rows[2].impulse, bodies);
  return change;
}

double contact_violation(const ConstraintRow* rows, double friction) {
  if (std::isnan(rows[0].residual + rows[1].residual + rows[2].residual)) return rows[0].residual;
  ContactImpulses next{};
  next.normal = pressed(rows[0], rows[0].residual);
  const double change = std::abs(next.normal - rows[0].impulse) * rows[0].inverse_mass;
  if (friction == 0.0) return change;
  rubbed(rows, rows[1].residual, rows[2].residual, friction * rows[0].impulse, next);
  return std::max(change, rubbing_change(rows, next));
}

}  // namespace

void ImpulseSolver::prepare(ConstraintSet& set, std::span<const SolverBody> bodies) {
  for (ConstraintRow& row : set.rows) {
    const SolverBody &a = bodies[index(row.a)], &b = bodies[index(row.b)];
    const RowDirections& on = row.impulse_on;
    row.spin_a = a.inverse_inertia * on.angular_a;
    row.spin_b = b.inverse_inertia * on.angular_b;
    const double own = (a.inverse_mass + b.inverse_mass) * on.linear.squaredNorm() +
                       row.spin_a.dot(on.angular_a) + row.spin_b.dot(on.angular_b);
    row.spin_a = a.inverse_inertia * row.rate_along.angular_a;
    row.spin_b = b.inverse_inertia * row.rate_along.angular_b;
    // Far-turned bodies must not change the sign.
    row.inverse_mass = std::max({coupling(row, row, bodies), 0.1 * own, 1e-300});
  }
}

double ImpulseSolver::violation(const ConstraintSet& set) const {
  double largest = 0.0;
  for (const ConstraintBlock& block : set.blocks)
    if (!block.idle) raise(largest, violation(set, block));
  return largest;
}

double ImpulseSolver::violation(const ConstraintSet& set, const ConstraintBlock& block) const {
  const ConstraintRow* rows = &set.rows[index(block.first)];
  if (block.contact) return contact_violation(rows, block.friction);
  double largest = 0.0;
  for (int i = 0; i < block.count; ++i) raise(largest, std::abs(rows[i].residual));
  return largest;
}

double ImpulseSolver::sweep(ConstraintSet& set, std::span<SolverBody> bodies) {
  double change = 0.0;
  for (const ConstraintBlock& block : set.blocks) {
    if (block.idle) continue;
    ConstraintRow* rows = &set.rows[index(block.first)];
    if (block.contact) {
      change = std::max(change, sweep_contact(rows, block.friction, bodies));
      continue;
    }
    for (int i = 0; i < block.count; ++i) {
      const double rate = present_rate(rows[i], bodies);
      change = std::max(change, std::abs(rate));
      give(rows[i], -rate / rows[i].inverse_mass, bodies);
    }
  }
  return change;
}

double ImpulseSolver::solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance) {
  // Sweeps over long chains achieve nothing: their equations first.
  const bool joints =
      std::any_of(set.blocks.begin(), set.blocks.end(), [](const auto& b) { return !b.contact; });
  bool direct = !joints || direct_.solve(set, bodies, tolerance);
  double change = 0.0, least = 1e300;
  for (int round = 0; round < max_rounds; ++round) {
    for (int i = 0; i < sweeps_a_round; ++i)
      if ((change = sweep(set, bodies)) <= tolerance) return change;
    if (!(change < 100.0 * least)) break;  // runs away
    least = std::min(least, change);
    direct = direct && direct_.solve(set, bodies, tolerance);
  }
  return change;
}

}  // namespace isochor
