#pragma once
#include <array>
#include <compare>
#include <span>
#include <vector>

#include "core/common/disjoint_sets.h"
#include "core/rigid/constraint_set.h"
#include "core/rigid/skyline_lu.h"

namespace isochor {

/// Newton's method for a set's rows that hold as equations, which its impulses tell: those of joints, the
/// normals of contacts that press, the tangents of those that stick. A contact that slides drags its friction
/// along with its normal impulse, in a direction that turns with that of its sliding.
class DirectSolver {
 public:
  /// Changes the impulses and gathers the momenta, on the ways on which contacts press and stay within
  /// Coulomb's cone; where they come to slide or to part they are taken as such from there. False when the
  /// equations have no solution or are too many.
  bool solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance);

  /// The equations as they are, sliding without friction; for respond().
  void hold(const ConstraintSet& set, std::span<const SolverBody> bodies);
  /// Adds to the bodies' momenta those by which the rows held answer them.
  void respond(std::span<SolverBody> bodies);

 private:
  struct Equation {
    ConstraintRow row;  ///< a sum of the block's; its impulse is since the choice
    const ConstraintBlock* block = nullptr;
    bool normal = false, sticks = false;
    std::array<double, 6> shares{};  ///< impulses of the block's rows for one of this
    double slack = 0.0;              ///< rate that stays, per impulse against it
    int group = 0;
  };

  static Equation equation_of(const ConstraintSet& set, const ConstraintBlock& block, int i);
  enum class Sliding { with_friction, without };
  /// Blocks by the bodies that they join with each other, so that each such group has an envelope of its own.
  void put_in_order(const ConstraintSet& set, std::span<const SolverBody> bodies);
  void choose(const ConstraintSet& set, std::span<const SolverBody> bodies, Sliding sliding);
  void add_friction(const ConstraintRow* rows, std::span<const SolverBody> bodies);
  bool factorize(std::span<const SolverBody> bodies);
  /// The places of a group's equations.
  struct Range {
    std::size_t begin, end;
  };
  double feasible_step(const ConstraintSet& set, const Range& range, const ConstraintBlock*& parting) const;
  double advance(ConstraintSet& set, const Range& range, std::span<SolverBody> bodies);
  double advance(ConstraintSet& set, std::span<SolverBody> bodies);

  DisjointSets groups_;
  struct Place {
    int group, block;
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> order_;
  std::vector<Equation> equations_;
  std::vector<int> first_, first_of_body_;
  std::vector<double> unknowns_;
  SkylineLu factor_;
  bool holds_ = false;
};

}  // namespace isochor
