#include "core/rigid/rigid_world.h"

#include <gtest/gtest.h>

#include "core/common/error.h"

namespace isochor {
namespace {

RigidBodyDesc ball(double radius, double mass, const Vec3& position) {
  RigidBodyDesc desc;
  desc.shape = make_sphere(radius);
  desc.mass = mass;
  desc.pose.position = position;
  return desc;
}

TEST(RigidWorld, FreeFallIsTheParabolaWhateverTheStep) {
  for (const double h : {0.1, 1.0 / 60.0, 1e-3}) {
    RigidWorld world;
    world.set_gravity({0.0, -9.81, 0.0});
    RigidBodyDesc desc = ball(0.1, 2.0, {0.0, 10.0, 0.0});
    desc.velocity = {1.0, 2.0, 0.0};
    world.add_body(desc);
    while (world.time() < 0.5) world.step(h);
    const double t = world.time();
    EXPECT_NEAR(world.pose(0).position.y(), 10.0 + 2.0 * t - 0.5 * 9.81 * t * t, 1e-12);
    EXPECT_NEAR(world.pose(0).position.x(), t, 1e-13);
    EXPECT_NEAR(world.state(0).velocity.y(), 2.0 - 9.81 * t, 1e-12);
  }
}

TEST(RigidWorld, MovingBodiesFollowTheirMotionAndTellTheirVelocity) {
  RigidWorld world;
  RigidBodyDesc plate;
  plate.shape = make_box({1.0, 0.1, 1.0});
  plate.motion = Motion{};
  plate.motion->velocity = {0.0, -0.5, 0.0};
  plate.motion->angular_velocity = {0.0, 2.0, 0.0};
  plate.motion->until = 0.25;
  world.add_body(plate);
  world.begin_step(0.1);
  EXPECT_NEAR((world.velocity_at(0, {1.0, 0.0, 0.0}) - Vec3(0.0, -0.5, -2.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(world.predicted_pose(0).position.y(), -0.05, 1e-15);
  world.end_step();
  for (int i = 0; i < 5; ++i) world.step(0.1);
  EXPECT_NEAR(world.pose(0).position.y(), -0.125, 1e-15);
  EXPECT_FALSE(world.dynamic(0));
  EXPECT_FALSE(world.immobile(0));
}

TEST(RigidWorld, AMovedBodyArrivesWithinTheTimeGiven) {
  RigidWorld world;
  RigidBodyDesc wall;
  wall.shape = make_plane(Vec3::UnitY(), 0.0);
  world.add_body(wall);
  EXPECT_TRUE(world.immobile(0));
  world.move_body(0, {{0.0, 1.0, 0.0}, Eigen::Quaterniond::Identity()}, 0.1);
  world.step(0.05);
  EXPECT_NEAR(world.pose(0).position.y(), 0.5, 1e-15);
  world.step(0.05);
  world.step(0.05);
  EXPECT_NEAR(world.pose(0).position.y(), 1.0, 1e-15);
  world.move_body(0, {{0.0, 3.0, 0.0}, Eigen::Quaterniond::Identity()}, 0.0);
  EXPECT_EQ(world.pose(0).position.y(), 3.0);
}

TEST(RigidWorld, ImpulsesWithinAStepMoveThePredictedPose) {
  RigidWorld world;
  world.add_body(ball(0.5, 2.0, Vec3::Zero()));
  world.begin_step(0.1);
  world.apply_impulse(0, {0.0, 0.5, 0.0}, {4.0, 0.0, 0.0});
  EXPECT_NEAR(world.predicted_pose(0).position.x(), 0.2, 1e-15);
  // ω = −r p / (0.4 m r²) about z.
  EXPECT_NEAR(rotation_log(world.predicted_pose(0).orientation).z(), -0.1 * 0.5 * 4.0 / (0.4 * 2.0 * 0.25),
              1e-12);
  const Vec3 momentum = world.angular_momentum();
  world.end_step();
  EXPECT_EQ(world.angular_momentum(), momentum);
  EXPECT_NEAR((momentum - Vec3(0.0, 0.0, -2.0)).norm(), 0.0, 1e-15);
}

/// A load lessens what an impulse does at once; without it the body has the whole of it.
TEST(RigidWorld, LoadsAnswerAlongAndLoseNoMomentum) {
  RigidWorld world;
  world.add_body(ball(0.5, 2.0, Vec3::Zero()));
  world.begin_step(0.1);
  world.carry(0, 6.0);
  world.apply_impulse(0, {0.0, 0.5, 0.0}, {4.0, 0.0, 0.0});
  EXPECT_NEAR(world.state(0).velocity.x(), 0.5, 1e-15);
  world.carry(0, 2.0);  // 3 of the 4 kg m/s are owed, half of them to the load
  EXPECT_NEAR(world.state(0).velocity.x(), 0.5 + 0.75, 1e-15);
  world.apply_impulse(0, {0.0, 0.0, 0.5}, {0.0, 2.0, 0.0});
  world.move();
  world.put_down();
  world.end_step();
  EXPECT_NEAR((world.linear_momentum() - Vec3(4.0, 2.0, 0.0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR((world.angular_momentum() - Vec3(-1.0, 0.0, -2.0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR(1.0 / world.state(0).inverse_mass, 2.0, 0.0);
}

/// Put apart at once, two balls 5 cm deep in each other would fly off at depth/h, 50 m/s here.
TEST(RigidWorld, WhatIsPlacedInAnotherComesOutGently) {
  RigidWorld world;
  world.add_body(ball(0.1, 1.0, Vec3::Zero()));
  world.add_body(ball(0.1, 1.0, {0.15, 0.0, 0.0}));
  double fastest = 0.0;
  while (world.time() < 0.5) {
    world.step(1e-3);
    fastest = std::max(fastest, world.state(1).velocity.norm());
  }
  EXPECT_LT(fastest, 1.0);
  EXPECT_GT((world.pose(1).position - world.pose(0).position).norm(), 0.2 - 1e-6);
}

TEST(RigidWorld, MassesThatMakeNoSenseAreRefused) {
  RigidWorld world;
  EXPECT_THROW(world.add_body(ball(0.5, -1.0, Vec3::Zero())), Error);
  RigidBodyDesc plane;
  plane.shape = make_plane(Vec3::UnitY(), 0.0);
  plane.mass = 1.0;
  EXPECT_THROW(world.add_body(plane), Error);
}

}  // namespace
}  // namespace isochor
