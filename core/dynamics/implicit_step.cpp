#include "core/dynamics/implicit_step.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/common/wide.h"

namespace isochor {
namespace {

constexpr int most_iterations = 500;
constexpr int most_steps = 8;
/// Newton steps that take the matrix anew; it changes little after them.
constexpr int fresh_matrices = 2;

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
      right_side_(body.size(), body.mesh->cells.size()),
      step_(body.size(), body.mesh->cells.size()),
      multipliers_(body.mesh->cells.size()) {}

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
  if (body.has_pins) turned_ = body.positions;
  body.positions = turned_;
  std::ranges::fill(multipliers_, 0.0);
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

/// Returns what the forces lacked before it.
double ImplicitStep::newton_step(SoftBody& body, std::span<const BlockedParticle> blocked,
                                 std::span<const Vec3> pushes, double tolerance, bool linearize) {
  const double c = inertia_weight(scheme_), theta = end_weight(scheme_);
  const Coordinates* at = &body.positions;
  if (scheme_ == ImplicitScheme::energy_momentum) {
    for (auto [a, b, mean] : {std::tuple{&turned_.x, &body.positions.x, &middle_.x},
                              {&turned_.y, &body.positions.y, &middle_.y},
                              {&turned_.z, &body.positions.z, &middle_.z}})
      set_mean(a->data(), b->data(), mean->data(), mean->size());
    at = &middle_;
  }
  if (linearize) solver_.linearize(body, *at, theta * h_ * h_ / c, h_ / c, blocked);
  if (!linearize || at != &body.positions) solver_.measure(body, body.positions);
  find_balance(body);
  right_side_.nodes = balance_;
  for (std::size_t b = 0; b < blocked.size(); ++b) right_side_.nodes.add(blocked[b].particle, -pushes[b]);
  for (auto* axis : {&right_side_.nodes.x, &right_side_.nodes.y, &right_side_.nodes.z})
    for (double& r : *axis) r = -r;
  for (std::size_t i = 0; i < body.rest_volumes.size(); ++i)
    right_side_.cells[i] = body.rest_volumes[i] - solver_.volumes()[i];
  const double lacking = solver_.norm(body, right_side_);
  solver_.solve(body, right_side_, step_, tolerance, most_iterations);
  for (auto [u, x] : {std::pair{&step_.nodes.x, &body.positions.x},
                      {&step_.nodes.y, &body.positions.y},
                      {&step_.nodes.z, &body.positions.z},
                      {&step_.cells, &multipliers_}})
    add_scaled(1.0, u->data(), x->data(), x->size());
  return lacking;
}

void ImplicitStep::solve(SoftBody& body) {
  if (scheme_ == ImplicitScheme::energy_momentum) {
    // The forces end up in balance to a hundredth, so that the ledger has next to nothing to correct.
    constexpr double tenth = 0.1;
    double first = 0.0;
    for (int k = 0; k < most_steps; ++k) {
      const double lacking = newton_step(body, {}, {}, tenth, k < fresh_matrices);
      if (k == 0) first = lacking;
      if (lacking <= tenth * first) break;
    }
  } else {
    newton_step(body, {}, {}, 1e-3, true);
  }
  if (!body.has_pins) restore_momentum(body);
}

void ImplicitStep::solve(SoftBody& body, std::span<const BlockedParticle> blocked,
                         std::span<const Vec3> pushes) {
  constexpr double coarse = 0.02, balanced = 1e-2;
  double first = 0.0;
  for (int k = 0; k < most_steps; ++k) {
    const double lacking = newton_step(body, blocked, pushes, coarse, true);
    if (k == 0) first = lacking;
    if (lacking <= balanced * first) break;
  }
  find_balance(body);
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

void ImplicitStep::finish(SoftBody& body, double h) {
  velocities_from_positions(body, h);
  const double both = scheme_ == ImplicitScheme::energy_momentum ? 1.0 : 0.0;
  if (body.has_pins) {
    for (std::size_t i = 0; i < body.size() && both > 0.0; ++i)
      body.velocities.set(i, 2.0 * body.velocities.at(i) - deformation_.at(i) / h);
    return;
  }
  const Vec3 angular_momentum = moment(body, body.start_positions, body.velocities);
  const Vec3 start = mass_center(body, body.start_positions), end = mass_center(body, body.positions);
  const Vec3 velocity = (end - start) / h;
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
  const std::size_t doubles = 6 * 3 * turned_.size() + 3 * multipliers_.size();
  return solver_.bytes() + static_cast<std::int64_t>(doubles * sizeof(double));
}

}  // namespace isochor
