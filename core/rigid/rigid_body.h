#pragma once
#include "core/collision/pose.h"

namespace isochor {

/// State and mass of one rigid body about its centre of mass. The angular momentum is the state, not the
/// angular velocity: without torque it is constant, so free flight keeps it to the last bit.
struct RigidBodyState {
  Pose pose;
  Vec3 velocity = Vec3::Zero();                               ///< m/s
  Vec3 angular_momentum = Vec3::Zero();                       ///< kg m²/s, world axes
  double inverse_mass = 0.0;                                  ///< 1/kg; 0: static or moved by its motion
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();          ///< kg m², body axes
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  ///< body axes

  bool dynamic() const { return inverse_mass > 0.0; }
  Eigen::Matrix3d world_inverse_inertia() const {
    const Eigen::Matrix3d r = pose.orientation.toRotationMatrix();
    return r * inverse_inertia * r.transpose();
  }
  Vec3 angular_velocity() const {
    return pose.orientation * (inverse_inertia * (pose.orientation.conjugate() * angular_momentum));
  }
};

/// v += p/m, L += (point − x)×p.
void apply_impulse(RigidBodyState& body, const Vec3& point, const Vec3& impulse);

/// Velocity that a unit impulse at the point gives to it there: 1/m − [r]× I⁻¹ [r]×.
Eigen::Matrix3d inverse_mass_at(const RigidBodyState& body, const Vec3& point);

double kinetic_energy(const RigidBodyState& body);

/// Orientation after h seconds of torque-free rotation. Each part of the step turns by exp(τω) about
/// ω = I⁻¹(L₀ + L₁)/2, both in body axes [after Simo & Wong 1991]: L₁ = exp(−τω)L₀ keeps ω·L, hence the
/// energy ½L·I⁻¹L, and in the world L does not change at all; both to round-off for any h. A negative h runs
/// back.
Eigen::Quaterniond rotate_freely(const RigidBodyState& body, double h);

/// The pose after h seconds at the present velocity and angular momentum.
Pose drift(const RigidBodyState& body, double h);

}  // namespace isochor
