#include "core/dynamics/implicit_step.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace isochor {
namespace {

constexpr double solver_tolerance = 1e-3;
constexpr int most_iterations = 2000;

Eigen::Matrix3d rotation_by(const Vec3& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

}  // namespace

ImplicitStep::ImplicitStep(const SoftBody& body)
    : solver_(body), displacement_(body.size()), force_(body.size()) {}

/// displacement_ = h·d.
RigidPart ImplicitStep::split_velocities(const SoftBody& body, double h) {
  RigidPart motion = body.has_pins ? RigidPart{} : rigid_part(body, body.positions, body.velocities);
  rotation_ = rotation_by(h * motion.angular_velocity);
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 rigid = motion.velocity + motion.angular_velocity.cross(body.positions.at(i) - motion.center);
    displacement_.set(i, h * (body.velocities.at(i) - rigid));
  }
  return motion;
}

void ImplicitStep::predict(SoftBody& body, double h) {
  const RigidPart motion = split_velocities(body, h);
  for (auto* axis : {&force_.x, &force_.y, &force_.z}) std::ranges::fill(*axis, 0.0);
  SpringMaterial elastic = body.material;
  elastic.damping = 0.0;
  add_spring_forces(body.springs, elastic, body.positions, body.velocities, force_);
  solver_.linearize(body, h * h, h);
  solver_.advance(body, h * h, force_, displacement_, solver_tolerance, most_iterations);
  turn(body, motion, h);
}

void ImplicitStep::filter(SoftBody& body, double h) {
  for (auto* axis : {&displacement_.x, &displacement_.y, &displacement_.z}) std::ranges::fill(*axis, 0.0);
  solver_.linearize(body, 0.25 * h * h, 0.5 * h);
  solver_.advance(body, 1.0, body.forces, displacement_, solver_tolerance, most_iterations);
  for (std::size_t i = 0; i < body.size(); ++i) body.forces.set(i, body.masses[i] * displacement_.at(i));
}

void ImplicitStep::drift(SoftBody& body, double h) {
  turn(body, split_velocities(body, h), h);
}

void ImplicitStep::turn(SoftBody& body, const RigidPart& motion, double h) {
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) + displacement_.at(i) - motion.center;
    body.positions.set(i, motion.center + rotation_ * moved);
  }
  if (!body.has_pins) restore_momentum(body, motion.center + h * motion.velocity, h);
}

// Springs carry no momentum. What the linear solve has done to it, a rotation and a translation of the end
// take back, which neither volumes nor springs feel.
void ImplicitStep::restore_momentum(SoftBody& body, const Vec3& center, double h) {
  constexpr int most_corrections = 12;
  constexpr double round_off = 1e-15;
  const Vec3 kept = h * moment(body, body.start_positions, body.velocities);
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
  if (body.has_pins) return;
  const Vec3 angular_momentum = moment(body, body.start_positions, body.velocities);
  const Vec3 start = mass_center(body, body.start_positions), end = mass_center(body, body.positions);
  const Vec3 velocity = (end - start) / h;
  // d, turned to the end of the step.
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) - end - rotation_ * (body.start_positions.at(i) - start);
    body.velocities.set(i, moved / h);
  }
  const Vec3 missing = angular_momentum - moment(body, body.positions, body.velocities);
  const Vec3 spin = spin_of(body, body.positions, missing);
  for (std::size_t i = 0; i < body.size(); ++i)
    body.velocities.add(i, velocity + spin.cross(body.positions.at(i) - end));
}

std::int64_t ImplicitStep::bytes() const {
  return solver_.bytes() + static_cast<std::int64_t>(6 * force_.size() * sizeof(double));
}

}  // namespace isochor
