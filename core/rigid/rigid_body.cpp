#include "core/rigid/rigid_body.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

constexpr double turn_per_part = 0.2;  // radians; the phase error of a part is of third order in it
constexpr int max_parts = 64;

/// Right Jacobian of the rotation group: exp(φ + δ) = exp(φ)·exp(J(φ)δ) to first order.
Eigen::Matrix3d right_jacobian(const Vec3& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d k = cross_matrix(phi);
  if (angle < 1e-4) return Eigen::Matrix3d::Identity() - 0.5 * k;
  const double a = (1.0 - std::cos(angle)) / (angle * angle);
  const double b = (angle - std::sin(angle)) / (angle * angle * angle);
  return Eigen::Matrix3d::Identity() - a * k + b * k * k;
}

/// ω with Iω = (L + exp(−τω)L)/2 by Newton's method.
Vec3 mean_angular_velocity(const RigidBodyState& body, const Vec3& momentum, double tau) {
  Vec3 omega = body.inverse_inertia * momentum;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::Matrix3d turn = rotation_exp(-tau * omega).toRotationMatrix();
    const Vec3 residual = body.inertia * omega - 0.5 * (momentum + turn * momentum);
    if (residual.norm() <= 1e-15 * momentum.norm()) break;
    const Eigen::Matrix3d derivative =
        body.inertia - 0.5 * tau * turn * cross_matrix(momentum) * right_jacobian(-tau * omega);
    omega -= derivative.inverse() * residual;
  }
  return omega;
}

}  // namespace

void apply_impulse(RigidBodyState& body, const Vec3& point, const Vec3& impulse) {
  if (!body.dynamic()) return;
  body.velocity += body.inverse_mass * impulse;
  body.angular_momentum += (point - body.pose.position).cross(impulse);
}

Eigen::Matrix3d inverse_mass_at(const RigidBodyState& body, const Vec3& point) {
  if (!body.dynamic()) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d r = cross_matrix(point - body.pose.position);
  return body.inverse_mass * Eigen::Matrix3d::Identity() - r * body.world_inverse_inertia() * r;
}

double kinetic_energy(const RigidBodyState& body) {
  if (!body.dynamic()) return 0.0;
  return 0.5 * body.velocity.squaredNorm() / body.inverse_mass +
         0.5 * body.angular_momentum.dot(body.angular_velocity());
}

Eigen::Quaterniond rotate_freely(const RigidBodyState& body, double h) {
  Eigen::Quaterniond q = body.pose.orientation;
  const double turn = std::abs(h) * body.angular_velocity().norm();
  if (!(turn > 0.0)) return q;
  const int parts = static_cast<int>(std::clamp(std::ceil(turn / turn_per_part), 1.0, double{max_parts}));
  const double tau = h / parts;
  for (int part = 0; part < parts; ++part) {
    const Vec3 momentum = q.conjugate() * body.angular_momentum;
    q = (q * rotation_exp(tau * mean_angular_velocity(body, momentum, tau))).normalized();
  }
  return q;
}

Pose drift(const RigidBodyState& body, double h) {
  return {body.pose.position + h * body.velocity, rotate_freely(body, h)};
}

}  // namespace isochor
