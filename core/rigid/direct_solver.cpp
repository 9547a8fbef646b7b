#include "core/rigid/direct_solver.h"

#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

// Of rows that depend on each other, as those of a face at rest on four points, which then share what they
// bear. Where they do not agree quite, what they disagree by over the shift is pressed against each other:
// more than any of them bears, if it is next to nothing.
constexpr double shift = 1e-6;
constexpr int refinements = 3, max_passes = 12;
constexpr std::int64_t envelope_limit = 2'000'000;  // entries, 16 MB
constexpr double stick_margin = 1.0 - 1e-9;
constexpr double stiffest_turn = 1e12;  // of friction, of its own row: it goes as 1/λ_n

Eigen::Vector2d tangential_impulse(const ConstraintRow* rows) {
  return {rows[1].impulse, rows[2].impulse};
}

void add_directions(RowDirections& sum, double factor, const RowDirections& directions) {
  sum.linear += factor * directions.linear;
  sum.angular_a += factor * directions.angular_a;
  sum.angular_b += factor * directions.angular_b;
}

/// The row whose rate is this combination of the tangents'.
ConstraintRow combination(const ConstraintRow* rows, const Eigen::Vector2d& factors) {
  ConstraintRow sum;
  sum.a = rows->a, sum.b = rows->b;
  for (int i = 0; i < 2; ++i) {
    const ConstraintRow& tangent = rows[i + 1];
    add_directions(sum.impulse_on, factors[i], tangent.impulse_on);
    add_directions(sum.rate_along, factors[i], tangent.rate_along);
    sum.spin_a += factors[i] * tangent.spin_a;
    sum.spin_b += factors[i] * tangent.spin_b;
    sum.residual += factors[i] * tangent.residual;
  }
  return sum;
}

/// Where the ray λ + s·δ leaves Coulomb's cone: |λ_t + sδ_t|² = μ²(λ_n + sδ_n)² for the least s > 0.
double cone_exit(const ConstraintRow* rows, const double* change, double friction) {
  const double mu2 = friction * friction;
  const double n = rows[0].impulse, t1 = rows[1].impulse, t2 = rows[2].impulse;
  const double a = change[1] * change[1] + change[2] * change[2] - mu2 * change[0] * change[0];
  const double b = t1 * change[1] + t2 * change[2] - mu2 * n * change[0];
  const double c = std::min(0.0, t1 * t1 + t2 * t2 - mu2 * n * n);  // inside
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return 1.0;
  const double root = -b + std::sqrt(discriminant);  // c ≤ 0: the exit is −c/(b + √) or (−b + √)/a
  const double exit = b > 0.0 ? -c / (b + std::sqrt(discriminant)) : a > 0.0 ? root / a : 1.0;
  return exit >= 0.0 ? exit : 1.0;
}

/// Onto the cone, which a turn leaves in the second order.
void put_on_cone(ConstraintRow* rows, double friction, std::span<SolverBody> bodies) {
  const double length = tangential_impulse(rows).norm();
  if (length == 0.0) return;
  const double lacking = friction * rows[0].impulse / length - 1.0;
  for (int i = 1; i < 3; ++i) give(rows[i], lacking * rows[i].impulse, bodies);
}

}  // namespace

DirectSolver::Equation DirectSolver::equation_of(const ConstraintSet& set, const ConstraintBlock& block,
                                                 int i) {
  Equation equation;
  equation.row = set.rows[index(block.first + i)];
  equation.row.impulse = 0.0;
  equation.block = &block;
  equation.normal = block.contact && i == 0;
  equation.shares[index(i)] = 1.0;
  return equation;
}

void DirectSolver::put_in_order(const ConstraintSet& set, std::span<const SolverBody> bodies) {
  const auto moves = [&](int body) { return bodies[index(body)].inverse_mass > 0.0; };
  groups_.reset(bodies.size());
  order_.clear();
  for (const ConstraintBlock& block : set.blocks) {
    const ConstraintRow& row = set.rows[index(block.first)];
    if (!block.idle && moves(row.a) && moves(row.b)) groups_.join(row.a, row.b);
  }
  for (int b = 0; b < static_cast<int>(set.blocks.size()); ++b) {
    const ConstraintBlock& block = set.blocks[index(b)];
    const ConstraintRow& row = set.rows[index(block.first)];
    if (!block.idle) order_.push_back({groups_.root(moves(row.a) ? row.a : row.b), b});
  }
  std::ranges::sort(order_);
}

void DirectSolver::choose(const ConstraintSet& set, std::span<const SolverBody> bodies, Sliding sliding) {
  put_in_order(set, bodies);
  equations_.clear();
  for (const Place& place : order_) {
    const ConstraintBlock& block = set.blocks[index(place.block)];
    const ConstraintRow* rows = &set.rows[index(block.first)];
    int count = block.count;
    bool sticks = false;
    if (block.contact) {
      const double limit = block.friction * rows[0].impulse;
      sticks = tangential_impulse(rows).norm() < stick_margin * limit;
      count = !(rows[0].impulse > 0.0) ? 0 : sticks ? 3 : 1;
    }
    for (int i = 0; i < count; ++i) {
      equations_.push_back(equation_of(set, block, i));
      equations_.back().sticks = sticks;
      equations_.back().group = place.group;
    }
    if (block.contact && count == 1 && block.friction > 0.0 && sliding == Sliding::with_friction)
      add_friction(rows, bodies);
  }
}

/// To the last equation, of a normal. The impulse μλ_n·d is against the sliding: where d turns by an angle
/// δλ/(μλ_n), the rate across it changes by that angle times the speed.
void DirectSolver::add_friction(const ConstraintRow* rows, std::span<const SolverBody> bodies) {
  Equation &normal = equations_.back(), across = normal;
  const double friction = normal.block->friction;
  const Eigen::Vector2d d = tangential_impulse(rows).normalized();
  const ConstraintRow along = combination(rows, d);
  add_directions(normal.row.impulse_on, friction, along.impulse_on);
  normal.shares = {1.0, friction * d[0], friction * d[1]};
  normal.row.inverse_mass = coupling(normal.row, normal.row, bodies);
  across.normal = false;
  across.row = combination(rows, {-d[1], d[0]});
  across.shares = {0.0, -d[1], d[0]};
  const double own = coupling(across.row, across.row, bodies),
               speed = std::max(-present_rate(along, bodies), 0.0);
  across.slack = std::min(speed / (friction * rows[0].impulse), stiffest_turn * own);
  across.row.inverse_mass = own + across.slack;
  equations_.push_back(across);
}

bool DirectSolver::factorize(std::span<const SolverBody> bodies) {
  first_of_body_.assign(bodies.size(), -1);
  first_.clear();
  for (int i = 0; i < static_cast<int>(equations_.size()); ++i) {
    const ConstraintRow& row = equations_[index(i)].row;
    int first = i;
    for (const int body : {row.a, row.b}) {
      if (bodies[index(body)].inverse_mass == 0.0) continue;
      int& begin = first_of_body_[index(body)];
      if (begin < 0) begin = i;
      first = std::min(first, begin);
    }
    first_.push_back(first);
  }
  if (equations_.empty() || !factor_.reset(first_, envelope_limit)) return false;
  for (int i = 0; i < static_cast<int>(equations_.size()); ++i)
    for (int j = first_[index(i)]; j <= i; ++j) {
      const ConstraintRow &p = equations_[index(i)].row, &q = equations_[index(j)].row;
      factor_.lower(i, j) = i == j ? p.inverse_mass : coupling(p, q, bodies);
      if (j < i) factor_.upper(j, i) = coupling(q, p, bodies);
    }
  unknowns_.resize(equations_.size());
  return factor_.factorize(shift);
}

bool DirectSolver::solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance) {
  double step = 0.0;
  int full = 0;
  for (int pass = 0; pass < max_passes && full < refinements; ++pass) {
    if (step < 1.0) {
      choose(set, bodies, Sliding::with_friction);
      if (!factorize(bodies)) return false;
    }
    double largest = 0.0;
    for (std::size_t i = 0; i < equations_.size(); ++i) {
      const Equation& equation = equations_[i];
      unknowns_[i] = -present_rate(equation.row, bodies) - equation.slack * equation.row.impulse;
      raise(largest, std::abs(unknowns_[i]));
    }
    if (largest <= tolerance) break;
    factor_.solve(unknowns_);
    step = advance(set, bodies);
    if (step == 1.0) ++full;
  }
  return true;
}

/// The part of the way to the solution on which no contact comes to pull and none leaves Coulomb's cone, and
/// the contact that is about to pull. The way as far as that lowers the energy for certain; beyond, the
/// choice of equations was wrong.
double DirectSolver::feasible_step(const ConstraintSet& set, const Range& range,
                                   const ConstraintBlock*& parting) const {
  double step = 1.0;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const Equation& equation = equations_[i];
    if (!equation.normal) continue;
    const ConstraintRow* rows = &set.rows[index(equation.block->first)];
    const double lifted = unknowns_[i] < 0.0 ? -rows[0].impulse / unknowns_[i] : 1.0;
    if (lifted < step) step = lifted, parting = equation.block;
    if (!equation.sticks) continue;
    const double slipped = cone_exit(rows, &unknowns_[i], equation.block->friction);
    if (slipped < step) step = slipped, parting = nullptr;
  }
  return step;
}

/// Each group as far as it may: the shortest of their steps.
double DirectSolver::advance(ConstraintSet& set, std::span<SolverBody> bodies) {
  double shortest = 1.0;
  for (Range range{0, 0}; range.end < equations_.size(); range.begin = range.end) {
    const int group = equations_[range.begin].group;
    while (range.end < equations_.size() && equations_[range.end].group == group) ++range.end;
    shortest = std::min(shortest, advance(set, range, bodies));
  }
  return shortest;
}

double DirectSolver::advance(ConstraintSet& set, const Range& range, std::span<SolverBody> bodies) {
  const ConstraintBlock* parting = nullptr;
  const double step = feasible_step(set, range, parting);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    Equation& equation = equations_[i];
    ConstraintRow* rows = &set.rows[index(equation.block->first)];
    equation.row.impulse += step * unknowns_[i];
    for (int k = 0; k < equation.block->count; ++k)
      if (equation.shares[index(k)] != 0.0)
        give(rows[k], step * equation.shares[index(k)] * unknowns_[i], bodies);
  }
  if (parting)
    for (int i = 0; i < 3; ++i) {
      ConstraintRow& row = set.rows[index(parting->first + i)];
      give(row, -row.impulse, bodies);
    }
  for (std::size_t i = range.begin; i < range.end; ++i)
    if (const Equation& equation = equations_[i]; equation.normal && !equation.sticks)
      put_on_cone(&set.rows[index(equation.block->first)], equation.block->friction, bodies);
  return step;
}

void DirectSolver::hold(const ConstraintSet& set, std::span<const SolverBody> bodies) {
  choose(set, bodies, Sliding::without);
  holds_ = factorize(bodies);
}

void DirectSolver::respond(std::span<SolverBody> bodies) {
  if (!holds_) return;
  for (int pass = 0; pass < refinements; ++pass) {
    for (std::size_t i = 0; i < equations_.size(); ++i)
      unknowns_[i] = -gathered_rate(equations_[i].row, bodies);
    factor_.solve(unknowns_);
    for (std::size_t i = 0; i < equations_.size(); ++i) add_momenta(equations_[i].row, unknowns_[i], bodies);
  }
}

}  // namespace isochor
