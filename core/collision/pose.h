#pragma once
#include "core/common/types.h"

namespace isochor {

/// A rigid placement: world = orientation·local + position.
struct Pose {
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

  Vec3 to_world(const Vec3& local) const { return orientation * local + position; }
  Vec3 to_local(const Vec3& world) const { return orientation.conjugate() * (world - position); }
};

/// Rotation by |rotation| radians about its direction.
inline Eigen::Quaterniond rotation_exp(const Vec3& rotation) {
  const double angle = rotation.norm();
  if (angle < 1e-8)
    return Eigen::Quaterniond(1.0, 0.5 * rotation.x(), 0.5 * rotation.y(), 0.5 * rotation.z()).normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle));
}

/// The inverse of rotation_exp, at most π long.
inline Vec3 rotation_log(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0, sine = q.vec().norm();
  if (sine < 1e-8) return 2.0 * sign * q.vec();
  return 2.0 * sign * std::atan2(sine, sign * q.w()) / sine * q.vec();
}

inline Eigen::Matrix3d cross_matrix(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace isochor
