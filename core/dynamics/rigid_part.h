#pragma once
#include "core/dynamics/soft_body.h"

namespace isochor {

/// The rigid motion that carries the momentum of a body: v = velocity + angular_velocity × (x − center), and
/// a rest without linear or angular momentum.
struct RigidPart {
  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  ///< m, m/s, 1/s

  Vec3 velocity_at(const Vec3& x) const { return velocity + angular_velocity.cross(x - center); }
};

/// Σ m r × v about the centre of x, divided by the inertia of x; axes about which there is none do not turn.
RigidPart rigid_part(const SoftBody& body, const Coordinates& x, const Coordinates& v);

Vec3 mass_center(const SoftBody& body, const Coordinates& x);
/// Σ m (a − center of a) × (b − center of b).
Vec3 moment(const SoftBody& body, const Coordinates& a, const Coordinates& b);
/// ω with I·ω = the angular momentum.
Vec3 spin_of(const Eigen::Matrix3d& inertia, const Vec3& angular_momentum);
/// The same, of the body at x.
Vec3 spin_of(const SoftBody& body, const Coordinates& x, const Vec3& angular_momentum);

}  // namespace isochor
