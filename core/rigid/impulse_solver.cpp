#include "core/rigid/impulse_solver.h"

#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

constexpr int sweeps_a_round = 10, max_rounds = 20, refinements = 3;
constexpr double shift = 1e-11;                     // of the direct solve, for rows that depend on each other
constexpr std::int64_t envelope_limit = 2'000'000;  // entries, 16 MB
constexpr double stick_margin = 1.0 - 1e-9;

/// The larger one; not a number stays so.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = value;
}

/// What the momenta gathered so far add to the row's rate.
double gathered_rate(const ConstraintRow& row, std::span<const SolverBody> bodies) {
  const SolverBody &a = bodies[index(row.a)], &b = bodies[index(row.b)];
  return row.rate_along.linear.dot(a.inverse_mass * a.impulse - b.inverse_mass * b.impulse) +
         row.spin_a.dot(a.angular_impulse) - row.spin_b.dot(b.angular_impulse);
}

void add_momenta(const ConstraintRow& row, double impulse, std::span<SolverBody> bodies) {
  SolverBody &a = bodies[index(row.a)], &b = bodies[index(row.b)];
  a.impulse += impulse * row.impulse_on.linear;
  a.angular_impulse += impulse * row.impulse_on.angular_a;
  b.impulse -= impulse * row.impulse_on.linear;
  b.angular_impulse -= impulse * row.impulse_on.angular_b;
}

void give(ConstraintRow& row, double impulse, std::span<SolverBody> bodies) {
  row.impulse += impulse;
  add_momenta(row, impulse, bodies);
}

/// Entry of the matrix J M⁻¹ Jᵀ: the rate of row p per impulse of row q.
double coupling(const ConstraintRow& p, const ConstraintRow& q, std::span<const SolverBody> bodies) {
  const double linear = p.rate_along.linear.dot(q.impulse_on.linear);
  double sum = 0.0;
  if (p.a == q.a) sum += bodies[index(p.a)].inverse_mass * linear + p.spin_a.dot(q.impulse_on.angular_a);
  if (p.a == q.b) sum -= bodies[index(p.a)].inverse_mass * linear + p.spin_a.dot(q.impulse_on.angular_b);
  if (p.b == q.a) sum -= bodies[index(p.b)].inverse_mass * linear + p.spin_b.dot(q.impulse_on.angular_a);
  if (p.b == q.b) sum += bodies[index(p.b)].inverse_mass * linear + p.spin_b.dot(q.impulse_on.angular_b);
  return sum;
}

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
  const double length = std::hypot(result.tangent1, result.tangent2);
  if (length <= limit) return;
  result.tangent1 *= limit / length;
  result.tangent2 *= limit / length;
}

double sweep_contact(ConstraintRow* rows, double friction, std::span<SolverBody> bodies) {
  ContactImpulses next{};
  next.normal = pressed(rows[0], rows[0].residual + gathered_rate(rows[0], bodies));
  double change = std::abs(next.normal - rows[0].impulse) * rows[0].inverse_mass;
  give(rows[0], next.normal - rows[0].impulse, bodies);
  if (friction == 0.0) return change;
  rubbed(rows, rows[1].residual + gathered_rate(rows[1], bodies),
         rows[2].residual + gathered_rate(rows[2], bodies), friction * next.normal, next);
  const double k = tangent_inverse_mass(rows);
  change = std::max(change, k * std::hypot(next.tangent1 - rows[1].impulse, next.tangent2 - rows[2].impulse));
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
  return std::max(change, tangent_inverse_mass(rows) *
                              std::hypot(next.tangent1 - rows[1].impulse, next.tangent2 - rows[2].impulse));
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
  for (const ConstraintBlock& block : set.blocks) {
    const ConstraintRow* rows = &set.rows[index(block.first)];
    if (block.contact) {
      raise(largest, contact_violation(rows, block.friction));
    } else {
      for (int i = 0; i < block.count; ++i) raise(largest, std::abs(rows[i].residual));
    }
  }
  return largest;
}

double ImpulseSolver::sweep(ConstraintSet& set, std::span<SolverBody> bodies) {
  double change = 0.0;
  for (const ConstraintBlock& block : set.blocks) {
    ConstraintRow* rows = &set.rows[index(block.first)];
    if (block.contact) {
      change = std::max(change, sweep_contact(rows, block.friction, bodies));
      continue;
    }
    for (int i = 0; i < block.count; ++i) {
      const double rate = rows[i].residual + gathered_rate(rows[i], bodies);
      change = std::max(change, std::abs(rate));
      give(rows[i], -rate / rows[i].inverse_mass, bodies);
    }
  }
  return change;
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

/// Joints, contacts that press, and the tangents of those that stick.
void ImpulseSolver::choose_active(const ConstraintSet& set, std::span<const SolverBody> bodies) {
  active_.clear();
  block_of_row_.assign(set.rows.size(), 0);
  for (const ConstraintBlock& block : set.blocks) {
    for (int i = 0; i < block.count; ++i)
      block_of_row_[index(block.first + i)] = static_cast<int>(&block - set.blocks.data());
    const ConstraintRow* rows = &set.rows[index(block.first)];
    int count = block.count;
    if (block.contact) {
      const bool presses = rows[0].impulse > 0.0;
      const bool sticks =
          std::hypot(rows[1].impulse, rows[2].impulse) < stick_margin * block.friction * rows[0].impulse;
      count = presses ? (sticks ? 3 : 1) : 0;
    }
    for (int i = 0; i < count; ++i) active_.push_back(block.first + i);
  }
  first_of_body_.assign(bodies.size(), -1);
  first_.clear();
  for (int i = 0; i < static_cast<int>(active_.size()); ++i) {
    const ConstraintRow& row = set.rows[index(active_[index(i)])];
    int first = i;
    for (const int body : {row.a, row.b}) {
      if (bodies[index(body)].inverse_mass == 0.0) continue;
      int& begin = first_of_body_[index(body)];
      if (begin < 0) begin = i;
      first = std::min(first, begin);
    }
    first_.push_back(first);
  }
}

bool ImpulseSolver::assemble(const ConstraintSet& set, std::span<const SolverBody> bodies) {
  if (active_.empty() || !factor_.reset(first_, envelope_limit)) return false;
  for (int i = 0; i < static_cast<int>(active_.size()); ++i)
    for (int j = first_[index(i)]; j <= i; ++j) {
      const ConstraintRow &p = set.rows[index(active_[index(i)])], &q = set.rows[index(active_[index(j)])];
      factor_.lower(i, j) = i == j ? p.inverse_mass : coupling(p, q, bodies);
      if (j < i) factor_.upper(j, i) = coupling(q, p, bodies);
    }
  return factor_.factorize(shift);
}

bool ImpulseSolver::solve_directly(ConstraintSet& set, std::span<SolverBody> bodies) {
  choose_active(set, bodies);
  if (!assemble(set, bodies)) return false;
  unknowns_.resize(active_.size());
  for (int pass = 0; pass < refinements; ++pass) {
    for (std::size_t i = 0; i < active_.size(); ++i) {
      const ConstraintRow& row = set.rows[index(active_[i])];
      unknowns_[i] = -(row.residual + gathered_rate(row, bodies));
    }
    factor_.solve(unknowns_);
    const double step = feasible_step(set);
    for (std::size_t i = 0; i < active_.size(); ++i)
      give(set.rows[index(active_[i])], step * unknowns_[i], bodies);
    if (step < 1.0) break;
  }
  return true;
}

void ImpulseSolver::hold(const ConstraintSet& set, std::span<const SolverBody> bodies) {
  choose_active(set, bodies);
  holds_ = assemble(set, bodies);
}

void ImpulseSolver::respond(const ConstraintSet& set, std::span<SolverBody> bodies) {
  if (!holds_) return;
  unknowns_.resize(active_.size());
  for (int pass = 0; pass < refinements; ++pass) {
    for (std::size_t i = 0; i < active_.size(); ++i)
      unknowns_[i] = -gathered_rate(set.rows[index(active_[i])], bodies);
    factor_.solve(unknowns_);
    for (std::size_t i = 0; i < active_.size(); ++i)
      add_momenta(set.rows[index(active_[i])], unknowns_[i], bodies);
  }
}

/// The part of the way to the solution on which no contact comes to pull and none leaves Coulomb's cone. The
/// way as far as that lowers the energy for certain; beyond, the choice of active rows was wrong.
double ImpulseSolver::feasible_step(const ConstraintSet& set) const {
  double step = 1.0;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const bool tangents = i + 1 < active_.size() && active_[i + 1] == active_[i] + 1;
    const auto block = block_of_row_[index(active_[i])];
    if (!set.blocks[index(block)].contact || set.blocks[index(block)].first != active_[i]) continue;
    const ConstraintRow* rows = &set.rows[index(active_[i])];
    if (unknowns_[i] < 0.0) step = std::min(step, -rows[0].impulse / unknowns_[i]);
    if (tangents) step = std::min(step, cone_exit(rows, &unknowns_[i], set.blocks[index(block)].friction));
  }
  return step;
}

double ImpulseSolver::solve(ConstraintSet& set, std::span<SolverBody> bodies, double tolerance) {
  // Sweeps over long chains achieve nothing: their equations first.
  const bool joints =
      std::any_of(set.blocks.begin(), set.blocks.end(), [](const auto& b) { return !b.contact; });
  bool direct = !joints || solve_directly(set, bodies);
  double change = 0.0, least = 1e300;
  for (int round = 0; round < max_rounds; ++round) {
    for (int i = 0; i < sweeps_a_round; ++i)
      if ((change = sweep(set, bodies)) <= tolerance) return change;
    if (!(change < 100.0 * least)) break;  // runs away
    least = std::min(least, change);
    direct = direct && solve_directly(set, bodies);
  }
  return change;
}

}  // namespace isochor
