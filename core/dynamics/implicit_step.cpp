#include "core/dynamics/implicit_step.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/common/wide.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

constexpr int most_iterations = 500;
const CarrierSpace nothing;
constexpr int most_steps = 12;

Eigen::Matrix3d rotation_by(const Vec3& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

ISOCHOR_MULTIVERSION void inertia(const double* m, const double* x, const double* turned, const double* d,
                                  double* __restrict out, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) out[i] = m[i] * (x[i] - turned[i] - d[i]);
}

ISOCHOR_MULTIVERSION void add_scaled(double factor, const double* a, double* __restrict b, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) b[i] += factor * a[i];
}

ISOCHOR_MULTIVERSION void set_mean(const double* a, const double* b, double* __restrict out,
                                   std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) out[i] = 0.5 * (a[i] + b[i]);
}

bool is_finite(const Coordinates& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x.x[i] + x.y[i] + x.z[i];
  return std::isfinite(sum);
}

double inertia_weight(ImplicitScheme scheme) {
  return scheme == ImplicitScheme::energy_momentum ? 2.0 : 1.0;
}
double end_weight(ImplicitScheme scheme) {
  return scheme == ImplicitScheme::energy_momentum ? 0.5 : 1.0;
}

}  // namespace

ImplicitStep::ImplicitStep(const SoftBody& body)
    : solver_(body),
      turned_(body.size()),
      deformation_(body.size()),
      middle_(body.size()),
      balance_(body.size()),
      free_(body.size()),
      solved_(body.size()),
      prescribed_(body.size()),
      right_side_(body.size(), body.mesh->cells.size()),
      step_(body.size(), body.mesh->cells.size()),
      multipliers_(body.mesh->cells.size()) {
  reactions_.reserve(body.surface_particles.size());
  targets_.reserve(body.surface_particles.size());
}

void ImplicitStep::begin(SoftBody& body, double h, ImplicitScheme scheme) {
  scheme_ = scheme;
  h_ = h;
  motion_ = body.has_pins ? RigidPart{} : rigid_part(body, body.positions, body.velocities);
  rotation_ = rotation_by(h * motion_.angular_velocity);
  const Vec3 center = motion_.center + h * motion_.velocity;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 arm = body.positions.at(i) - motion_.center;
    const Vec3 rigid = motion_.velocity + motion_.angular_velocity.cross(arm);
    deformation_.set(i, h * (rotation_ * (body.velocities.at(i) - rigid)));
    turned_.set(i, center + rotation_ * arm);
  }
  throw_if_scope_cancelled();
  if (body.has_pins) turned_ = body.positions;
  internal_energy_ = spring_energy(body.springs, body.material, body.positions);
  energy_ = internal_energy_ + kinetic_energy(body);
  for (std::size_t i = 0; i < body.size(); ++i)
    internal_energy_ += 0.5 / (h * h) * body.masses[i] * deformation_.at(i).squaredNorm();
  body.positions = solved_ = turned_;
  std::ranges::fill(multipliers_, 0.0);
  lacked_at_first_ = 0.0;
}

void ImplicitStep::find_balance(const SoftBody& body) {
  const double unit = h_ * h_ / inertia_weight(scheme_);
  for (auto* axis : {&balance_.x, &balance_.y, &balance_.z}) std::ranges::fill(*axis, 0.0);
  add_step_forces(body.springs, body.material, {end_weight(scheme_), h_}, turned_, body.positions, balance_);
  const auto finish_axis = [&](std::vector<double>& sum, const std::vector<double>& x,
                               const std::vector<double>& turned, const std::vector<double>& d) {
    auto& scratch = right_side_.nodes.x;
    inertia(body.masses.data(), x.data(), turned.data(), d.data(), scratch.data(), sum.size());
    add_scaled(-unit, sum.data(), scratch.data(), sum.size());
    std::swap(sum, scratch);
  };
  finish_axis(balance_.x, body.positions.x, turned_.x, deformation_.x);
  finish_axis(balance_.y, body.positions.y, turned_.y, deformation_.y);
  finish_axis(balance_.z, body.positions.z, turned_.z, deformation_.z);
  solver_.add_pressure(multipliers_, -1.0, balance_);
}

/// What the caller has moved since the last solve, pins and contacts, moves within it from where the body
/// was. Later steps bring blocked particles back to where they are held, which turning has left by the second
/// order.
bool ImplicitStep::take_prescribed(SoftBody& body, const Hold& hold, int count) {
  bool any = false;
  if (count == 0) {
    carried_ = Eigen::VectorXd::Zero(hold.carriers.size());
    targets_.clear();
    for (const BlockedParticle& held : hold.blocked) targets_.push_back(body.positions.at(held.particle));
    for (std::size_t i = 0; i < body.size(); ++i) {
      const Vec3 moved = body.positions.at(i) - solved_.at(i);
      prescribed_.set(i, moved);
      any |= !moved.isZero(0.0);
    }
    body.positions = solved_;
    return any;
  }
  for (auto* axis : {&prescribed_.x, &prescribed_.y, &prescribed_.z}) std::ranges::fill(*axis, 0.0);
  for (std::size_t b = 0; b < hold.blocked.size(); ++b) {
    const auto& [particle, inverse_mass] = hold.blocked[b];
    const Vec3 off = targets_[b] - body.positions.at(particle);
    prescribed_.set(particle, off - body.masses[particle] * (inverse_mass * off));
  }
  return !hold.blocked.empty();
}

/// Moves the body by the step: its rigid part by a rotation, which stretches nothing, and the rest as it is.
void ImplicitStep::move(SoftBody& body) {
  Coordinates& d = step_.nodes;
  const RigidPart part = body.has_pins ? RigidPart{} : rigid_part(body, body.positions, d);
  const Eigen::Matrix3d rotation = rotation_by(part.angular_velocity);
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 arm = body.positions.at(i) - part.center;
    const Vec3 rest = d.at(i) - part.velocity - part.angular_velocity.cross(arm);
    body.positions.set(i, part.center + part.velocity + rotation * (arm + rest));
  }
}

/// Returns what the forces lacked before it.
double ImplicitStep::newton_step(SoftBody& body, const Hold& hold, double tolerance, int count) {
  const double c = inertia_weight(scheme_), theta = end_weight(scheme_);
  const bool prescribed = take_prescribed(body, hold, count);
  const Coordinates* at = &body.positions;
  if (scheme_ == ImplicitScheme::energy_momentum) {
    for (auto [a, b, mean] : {std::tuple{&turned_.x, &body.positions.x, &middle_.x},
                              {&turned_.y, &body.positions.y, &middle_.y},
                              {&turned_.z, &body.positions.z, &middle_.z}})
      set_mean(a->data(), b->data(), mean->data(), mean->size());
    at = &middle_;
  }
  const bool fresh = count < hold.fresh_matrices;
  if (fresh) solver_.linearize(body, *at, theta * h_ * h_ / c, h_ / c, hold.blocked, hold.carriers);
  if (!fresh || at != &body.positions) solver_.measure(body, body.positions);
  find_balance(body);
  right_side_.nodes = balance_;
  for (std::size_t b = 0; b < hold.blocked.size(); ++b)
    right_side_.nodes.add(hold.blocked[b].particle, -hold.pushes[b]);
  for (auto* axis : {&right_side_.nodes.x, &right_side_.nodes.y, &right_side_.nodes.z})
    for (double& r : *axis) r = -r;
  hold.carriers.subtract_imbalance(carried_, right_side_.nodes);
  for (std::size_t i = 0; i < body.rest_volumes.size(); ++i)
    right_side_.cells[i] = body.rest_volumes[i] - solver_.volumes()[i];
  if (prescribed) solver_.subtract(body, prescribed_, right_side_);
  const double lacking = solver_.norm(body, right_side_);
  solver_.solve(body, right_side_, step_, tolerance, most_iterations);
  give_way(hold);
  if (prescribed)
    for (std::size_t i = 0; i < body.size(); ++i) step_.nodes.add(i, prescribed_.at(i));
  move(body);
  add_scaled(1.0, step_.cells.data(), multipliers_.data(), multipliers_.size());
  return lacking;
}

/// The targets go with what carries them.
void ImplicitStep::give_way(const Hold& hold) {
  if (hold.carriers.empty()) return;
  const Eigen::VectorXd step = hold.carriers.restricted(step_.nodes);
  carried_ += step;
  for (auto* axis : {&middle_.x, &middle_.y, &middle_.z}) std::ranges::fill(*axis, 0.0);
  hold.carriers.expand(step, middle_);
  for (std::size_t b = 0; b < hold.blocked.size(); ++b) targets_[b] += middle_.at(hold.blocked[b].particle);
}

/// Until what was lacking before the last step is, as an energy, lacking²/h², a hundredth of the energy
/// given, and `balanced` times what lacked at first in this substep or next to nothing. False when it never
/// is affordable, as soon as that shows.
bool ImplicitStep::iterate(SoftBody& body, const Hold& hold, double tolerance, double balanced,
                           double energy) {
  const double affordable = 0.1 * h_ * std::sqrt(energy);
  std::array<double, most_steps> lacked;
  double lacking = 0.0;
  for (int k = 0; k < most_steps; ++k) {
    lacking = lacked[k] = newton_step(body, hold, tolerance, k);
    if (is_lost(body, lacking, affordable)) return false;
    if (lacking <= affordable && lacking <= std::max(balanced * lacked_at_first_, 0.1 * affordable)) break;
    if (k >= 4 && lacking > 0.5 * lacked[k - 2]) break;
  }
  solved_ = body.positions;
  return lacking <= affordable;
}

/// Where Newton steps do not come back from.
bool ImplicitStep::is_lost(SoftBody& body, double lacking, double affordable) {
  constexpr double too_far = 10.0;
  if (lacked_at_first_ == 0.0) lacked_at_first_ = lacking;
  const bool near = lacking <= std::max(too_far * lacked_at_first_, affordable);
  if (near && is_finite(body.positions)) return false;
  body.positions = solved_;
  return true;
}

bool ImplicitStep::approach(SoftBody& body, const Hold& hold) {
  constexpr double tolerance = 0.1;
  const double lacking = newton_step(body, hold, tolerance, 0);
  if (is_lost(body, lacking, 0.0)) return false;
  solved_ = body.positions;
  return true;
}

void ImplicitStep::solve(SoftBody& body) {
  // The forces end up in balance to a hundredth, so that the ledger has next to nothing to correct.
  if (scheme_ == ImplicitScheme::energy_momentum)
    iterate(body, {{}, {}, nothing, 2}, 0.1, 0.1, internal_energy_);
  else if (body.has_pins)  // nothing turns with it, so that its path must be found
    iterate(body, {{}, {}, nothing, most_steps}, 0.02, 0.02, energy_);
  else
    newton_step(body, {{}, {}, nothing, 1}, 1e-3, 0);
  if (!body.has_pins) restore_momentum(body);
  solved_ = free_ = body.positions;
  lacked_at_first_ = 0.0;
}

void ImplicitStep::release(SoftBody& body) {
  body.positions = solved_ = free_;
}

bool ImplicitStep::solve(SoftBody& body, std::span<const BlockedParticle> blocked,
                         std::span<const Vec3> pushes, const CarrierSpace& carriers, Balance balance) {
  bool balanced = true;
  if (balance == Balance::full)
    balanced = iterate(body, {blocked, pushes, carriers, most_steps}, 0.02, 0.02, energy_);
  else
    balanced = approach(body, {blocked, pushes, carriers, 1});
  solver_.measure(body, body.positions);
  find_balance(body);
  return balanced;
}

std::span<const Vec3> ImplicitStep::reactions(std::span<const BlockedParticle> blocked) {
  reactions_.clear();
  for (const BlockedParticle& held : blocked) reactions_.push_back(balance_.at(held.particle));
  return reactions_;
}

// Springs carry no momentum. What the linear solve has done to it, a rotation and a translation of the end
// take back, which neither volumes nor springs feel.
void ImplicitStep::restore_momentum(SoftBody& body) {
  constexpr int most_corrections = 12;
  constexpr double round_off = 1e-15;
  const Vec3 kept = h_ * moment(body, body.start_positions, body.velocities);
  const Vec3 center = motion_.center + h_ * motion_.velocity;
  for (int k = 0; k < most_corrections; ++k) {
    const Vec3 missing = kept - moment(body, body.start_positions, body.positions);
    if (k > 0 && missing.norm() <= round_off * kept.norm()) break;
    const Eigen::Matrix3d correction = rotation_by(spin_of(body, body.start_positions, missing));
    const Vec3 from = mass_center(body, body.positions);
    for (std::size_t i = 0; i < body.size(); ++i)
      body.positions.set(i, center + correction * (body.positions.at(i) - from));
  }
}

void ImplicitStep::finish(SoftBody& body, double h, const std::optional<Vec3>& push) {
  velocities_from_positions(body, h);
  const double both = scheme_ == ImplicitScheme::energy_momentum ? 1.0 : 0.0;
  if (body.has_pins) {
    for (std::size_t i = 0; i < body.size() && both > 0.0; ++i)
      body.velocities.set(i, 2.0 * body.velocities.at(i) - deformation_.at(i) / h);
    return;
  }
  const Vec3 angular_momentum = moment(body, body.start_positions, body.velocities);
  const Vec3 start = mass_center(body, body.start_positions), end = mass_center(body, body.positions);
  const Vec3 velocity =
      push ? Vec3(motion_.velocity + *push / (h * body.total_mass)) : Vec3((end - start) / h);
  // d, turned to the end of the step.
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) - end - rotation_ * (body.start_positions.at(i) - start);
    body.velocities.set(i, ((1.0 + both) * moved - both * deformation_.at(i)) / h);
  }
  const Vec3 missing = angular_momentum - moment(body, body.positions, body.velocities);
  const Vec3 spin = spin_of(body, body.positions, missing);
  for (std::size_t i = 0; i < body.size(); ++i)
    body.velocities.add(i, velocity + spin.cross(body.positions.at(i) - end));
}

std::int64_t ImplicitStep::bytes() const {
  const std::size_t doubles = 9 * 3 * turned_.size() + 3 * multipliers_.size();
  return solver_.bytes() + static_cast<std::int64_t>(doubles * sizeof(double));
}

}  // namespace isochor
