#pragma once
#include <span>

#include "core/rigid/direct_solver.h"

namespace isochor {

/// Impulses that meet 0 ≤ λ_n ⟂ rate_n ≥ 0, |λ_t| ≤ μλ_n against the sliding, and rate = 0 for joints.
/// Sequential impulses [Bender & Schmitt 2006] find which contacts press, stick and slide; direct solves of
/// those equations, in which more may slide or part, remove the error that sequential impulses would take
/// mass ratio × contacts sweeps for.
class ImpulseSolver {
 public:
  /// Spins and inverse masses of the rows, whenever their directions have changed.
  void prepare(ConstraintSet& set, std::span<const SolverBody> bodies);
  /// Largest violation of the three laws, as a rate.
  double violation(const ConstraintSet& set) const;
  double violation(const ConstraintSet& set, const ConstraintBlock& block) const;
  /// From residuals taken with the bodies' momenta at zero: changes the impulses and gathers the momenta.
  /// Returns the violation left.
  double solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance);

  /// See DirectSolver.
  void hold(const ConstraintSet& set, std::span<const SolverBody> bodies) { direct_.hold(set, bodies); }
  void respond(std::span<SolverBody> bodies) { direct_.respond(bodies); }

 private:
  double sweep(ConstraintSet& set, std::span<SolverBody> bodies);

  DirectSolver direct_;
};

}  // namespace isochor
