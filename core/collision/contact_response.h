#pragma once
#include <algorithm>
#include <cmath>

#include "core/common/types.h"

namespace isochor {

/// The laws of contact as small functions of velocities and impulses.

/// Friction is iterated until it changes by less than this part of itself.
inline constexpr double friction_tolerance = 0.05;
/// A bounce slower than what gravity adds in a few substeps is rest, m/s.
inline constexpr double rest_speed = 0.05;
/// What stands within a surface as a substep begins comes out at this speed, in cells a second: put right at
/// once it would have a speed of its depth over h.
inline constexpr double recovery_speed = 6.0;

/// Of two surfaces in contact: the geometric mean, so that equal coefficients keep their value and a
/// frictionless one stays frictionless.
inline double combined_friction(double a, double b) {
  return std::sqrt(a * b);
}
/// The livelier one decides: a ball's restitution holds on any floor.
inline double combined_restitution(double a, double b) {
  return std::max(a, b);
}

/// Coulomb's cone: the tangential impulse, shortened to at most friction·normal [Bender & Schmitt 2006].
inline Vec3 clamp_to_cone(const Vec3& tangential, double friction, double normal) {
  const double limit = friction * std::max(normal, 0.0), length = tangential.norm();
  return length > limit ? Vec3(limit / length * tangential) : tangential;
}

/// Impulse onto the first of two bodies that meet with the given relative velocity (first − second) at a
/// point, by Poisson's two phases: the first ends the approach, its friction stops the sliding or opposes
/// what is left of it on Coulomb's cone; the second gives back `restitution` times the pressure of the first.
/// Where the masses do not couple normal and tangent (spheres, particles) the bodies part at restitution
/// times the speed of approach; Newton's rule would have it so always, and gains energy there (Kane's
/// paradox). inverse_mass is the sum of both bodies' at that point; the normal points to the first body. Zero
/// when they part already.
Vec3 impact_impulse(const Vec3& relative_velocity, const Vec3& normal, const Eigen::Matrix3d& inverse_mass,
                    double friction, double restitution);

}  // namespace isochor
