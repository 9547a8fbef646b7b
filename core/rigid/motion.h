#pragma once
#include <vector>

#include "core/collision/pose.h"

namespace isochor {

struct Keyframe {
  double t = 0.0;
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// A velocity until a time, after which the body stands still; or keyframes.
struct Motion {
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  double until = 1e300;
  std::vector<Keyframe> keyframes;
};

/// Where the motion has brought a body that stood at start when t was 0. Positions between keyframes are
/// linear, orientations turn at a constant rate the shorter way [Shoemake 1985]; before the first and after
/// the last the body stands still. Keyframes are in ascending order of t.
Pose pose_at(const Motion& motion, const Pose& start, double t);

}  // namespace isochor
