#include "core/rigid/motion.h"

#include <gtest/gtest.h>

#include <numbers>

namespace isochor {
namespace {

TEST(Motion, VelocityHoldsUntilItsTimeAndThenTheBodyStands) {
  Motion motion;
  motion.velocity = {0.0, -0.5, 0.0};
  motion.angular_velocity = {0.0, 0.0, 1.0};
  motion.until = 2.0;
  const Pose start{{1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity()};
  EXPECT_EQ(pose_at(motion, start, 0.0).position, start.position);
  EXPECT_EQ(pose_at(motion, start, 1.0).position, Vec3(1.0, 1.5, 3.0));
  for (const double t : {2.0, 2.5, 100.0}) {
    const Pose end = pose_at(motion, start, t);
    EXPECT_EQ(end.position, Vec3(1.0, 1.0, 3.0));
    EXPECT_LT((rotation_log(end.orientation) - Vec3(0.0, 0.0, 2.0)).norm(), 1e-15);
  }
}

TEST(Motion, KeyframesAreMetAndTurnTheShorterWay) {
  const double quarter = std::numbers::pi / 2.0;
  Motion motion;
  motion.keyframes = {
      {1.0, {0.0, 0.0, 0.0}, Eigen::Quaterniond::Identity()},
      {3.0, {2.0, 0.0, 0.0}, rotation_exp({0.0, quarter, 0.0})},
      {4.0, {2.0, 1.0, 0.0}, Eigen::Quaterniond(-rotation_exp({0.0, 2.0 * quarter, 0.0}).coeffs())}};
  for (const Keyframe& key : motion.keyframes) {
    const Pose pose = pose_at(motion, {}, key.t);
    EXPECT_EQ(pose.position, key.position);
    EXPECT_LT(pose.orientation.angularDistance(key.orientation), 1e-14);
  }
  EXPECT_LT((rotation_log(pose_at(motion, {}, 2.0).orientation) - Vec3(0.0, quarter / 2.0, 0.0)).norm(),
            1e-14);
  EXPECT_LT((rotation_log(pose_at(motion, {}, 3.5).orientation) - Vec3(0.0, 1.5 * quarter, 0.0)).norm(),
            1e-14);
  EXPECT_EQ(pose_at(motion, {}, 0.0).position, motion.keyframes.front().position);
  EXPECT_EQ(pose_at(motion, {}, 9.0).position, motion.keyframes.back().position);
}

}  // namespace
}  // namespace isochor
