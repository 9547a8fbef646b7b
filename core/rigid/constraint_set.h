#pragma once
#include <span>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// Directions of a scalar constraint between two bodies: of an impulse, or of the rate
/// linear·(v_a − v_b) + angular_a·ω_a − angular_b·ω_b.
struct RowDirections {
  Vec3 linear = Vec3::Zero(), angular_a = Vec3::Zero(), angular_b = Vec3::Zero();
};

/// One scalar constraint. An impulse λ gives a the momenta λ·linear and λ·angular_a of `impulse_on`, b the
/// opposite; `rate_along` differs from it where the impulse acts at the start of a step and the rate is that
/// of an error at its end.
struct ConstraintRow {
  int a = 0, b = 0;
  RowDirections impulse_on, rate_along;
  double residual = 0.0;  ///< rate left, to vanish (joints, sticking) or be ≥ 0 (contact normals)
  double impulse = 0.0;   ///< λ, summed

  Vec3 spin_a = Vec3::Zero(), spin_b = Vec3::Zero();  ///< I⁻¹·rate_along.angular, set by the solver
  double inverse_mass = 0.0;                          ///< rate of a unit λ, set by the solver
};

/// Rows that belong together: the equations of a joint, or the normal and two tangents of a contact.
struct ConstraintBlock {
  int first = 0, count = 0;
  bool contact = false;
  double friction = 0.0;
  bool idle = false;  ///< no solver changes its impulses
};

struct ConstraintSet {
  std::vector<ConstraintRow> rows;
  std::vector<ConstraintBlock> blocks;
  void clear() { rows.clear(), blocks.clear(); }
};

/// A body as the solver sees it, and the momenta that it has been given.
struct SolverBody {
  double inverse_mass = 0.0;
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  ///< world axes
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();
};

/// Of a body or a row as a place in an array.
inline std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// What the momenta gathered so far add to the row's rate.
inline double gathered_rate(const ConstraintRow& row, std::span<const SolverBody> bodies) {
  const SolverBody &a = bodies[index(row.a)], &b = bodies[index(row.b)];
  return row.rate_along.linear.dot(a.inverse_mass * a.impulse - b.inverse_mass * b.impulse) +
         row.spin_a.dot(a.angular_impulse) - row.spin_b.dot(b.angular_impulse);
}

inline double present_rate(const ConstraintRow& row, std::span<const SolverBody> bodies) {
  return row.residual + gathered_rate(row, bodies);
}

inline void add_momenta(const ConstraintRow& row, double impulse, std::span<SolverBody> bodies) {
  SolverBody &a = bodies[index(row.a)], &b = bodies[index(row.b)];
  a.impulse += impulse * row.impulse_on.linear;
  a.angular_impulse += impulse * row.impulse_on.angular_a;
  b.impulse -= impulse * row.impulse_on.linear;
  b.angular_impulse -= impulse * row.impulse_on.angular_b;
}

inline void give(ConstraintRow& row, double impulse, std::span<SolverBody> bodies) {
  row.impulse += impulse;
  add_momenta(row, impulse, bodies);
}

/// Entry of the matrix J M⁻¹ Jᵀ: the rate of row p per impulse of row q.
inline double coupling(const ConstraintRow& p, const ConstraintRow& q, std::span<const SolverBody> bodies) {
  const double linear = p.rate_along.linear.dot(q.impulse_on.linear);
  double sum = 0.0;
  if (p.a == q.a) sum += bodies[index(p.a)].inverse_mass * linear + p.spin_a.dot(q.impulse_on.angular_a);
  if (p.a == q.b) sum -= bodies[index(p.a)].inverse_mass * linear + p.spin_a.dot(q.impulse_on.angular_b);
  if (p.b == q.a) sum -= bodies[index(p.b)].inverse_mass * linear + p.spin_b.dot(q.impulse_on.angular_a);
  if (p.b == q.b) sum += bodies[index(p.b)].inverse_mass * linear + p.spin_b.dot(q.impulse_on.angular_b);
  return sum;
}

/// The larger one; not a number stays so.
inline void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value;
}

}  // namespace isochor
