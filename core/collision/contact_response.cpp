#include "core/collision/contact_response.h"

#include <Eigen/LU>

namespace isochor {
namespace {

bool inside_cone(const Vec3& impulse, const Vec3& normal, double friction) {
  const double pressed = normal.dot(impulse);
  return pressed >= 0.0 && (impulse - pressed * normal).norm() <= friction * pressed;
}

/// Sliding impulse that ends the approach: p = a/(n·K·(n + μt))·(n + μt) with t against the sliding that is
/// left, found by repetition. It need be repeated only where the masses couple the directions.
Vec3 sliding_impulse(const Vec3& relative_velocity, const Vec3& normal, const Eigen::Matrix3d& inverse_mass,
                     double friction, const Vec3& first_direction) {
  const double approach = -normal.dot(relative_velocity), plain = normal.dot(inverse_mass * normal);
  Vec3 direction = first_direction, impulse = approach / plain * normal;
  for (int i = 0; i < 50; ++i) {
    const Vec3 ray = normal + friction * direction;
    const double compliance = normal.dot(inverse_mass * ray);
    if (compliance < 0.1 * plain) return approach / plain * normal;  // would jam (Painlevé): frictionless
    impulse = approach / compliance * ray;
    const Vec3 left = relative_velocity + inverse_mass * impulse;
    const Vec3 sliding = left - normal.dot(left) * normal;
    if (sliding.norm() <= 1e-14 * relative_velocity.norm()) break;
    const Vec3 next = -sliding.normalized();
    if ((next - direction).norm() < 1e-12) break;
    direction = (direction + next).norm() > 1e-6 ? Vec3((direction + next).normalized()) : next;
  }
  return impulse;
}

}  // namespace

Vec3 impact_impulse(const Vec3& relative_velocity, const Vec3& normal, const Eigen::Matrix3d& inverse_mass,
                    double friction, double restitution) {
  if (normal.dot(relative_velocity) >= 0.0) return Vec3::Zero();
  const Eigen::Matrix3d mass = inverse_mass.inverse();
  const Vec3 stick = -mass * relative_velocity;
  if (!inside_cone(stick, normal, friction)) {
    const Vec3 tangential = stick - normal.dot(stick) * normal;
    return (1.0 + restitution) *
           sliding_impulse(relative_velocity, normal, inverse_mass, friction, tangential.normalized());
  }
  const Vec3 release = mass * normal / normal.dot(mass * normal);  // parts without sliding
  const Vec3 impulse = stick + restitution * normal.dot(stick) * release;
  return inside_cone(impulse, normal, friction) ? impulse : Vec3((1.0 + restitution) * stick);
}

}  // namespace isochor
