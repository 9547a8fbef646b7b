#pragma once
#include <span>
#include <vector>

#include "core/common/types.h"
#include "core/rigid/skyline_lu.h"

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

/// Impulses that meet 0 ≤ λ_n ⟂ rate_n ≥ 0, |λ_t| ≤ μλ_n against the sliding, and rate = 0 for joints.
/// Sequential impulses [Bender & Schmitt 2006] find which contacts press and which stick; a direct solve of
/// those equations removes the error that sequential impulses would take mass ratio × contacts sweeps for.
class ImpulseSolver {
 public:
  /// Spins and inverse masses of the rows, whenever their directions have changed.
  void prepare(ConstraintSet& set, std::span<const SolverBody> bodies);
  /// Largest violation of the three laws, as a rate.
  double violation(const ConstraintSet& set) const;
  /// From residuals taken with the bodies' momenta at zero: changes the impulses and gathers the momenta.
  /// Returns the violation left.
  double solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance);

  /// Which rows hold as equations, by their impulses; for respond().
  void hold(const ConstraintSet& set, std::span<const SolverBody> bodies);
  /// Adds to the bodies' momenta those by which the rows held answer them.
  void respond(const ConstraintSet& set, std::span<SolverBody> bodies);

 private:
  double sweep(ConstraintSet& set, std::span<SolverBody> bodies);
  bool solve_directly(ConstraintSet& set, std::span<SolverBody> bodies);
  double feasible_step(const ConstraintSet& set) const;
  void choose_active(const ConstraintSet& set, std::span<const SolverBody> bodies);
  bool assemble(const ConstraintSet& set, std::span<const SolverBody> bodies);

  SkylineLu factor_;
  std::vector<int> active_, first_, first_of_body_, block_of_row_;
  std::vector<double> unknowns_;
  bool holds_ = false;
};

}  // namespace isochor
