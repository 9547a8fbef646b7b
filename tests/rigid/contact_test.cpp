#include <gtest/gtest.h>

#include <cmath>

#include "tests/rigid/worlds.h"
#include "tests/support/print_shape_type.h"

namespace isochor {
namespace {

constexpr double g = 9.81, h = 1.0 / 60.0;

class SlidingBlock : public testing::TestWithParam<double> {};

TEST_P(SlidingBlock, StopsAfterTheClosedFormulasWay) {
  const double mu = GetParam(), v = 3.0;
  RigidWorld world = world_with_floor(mu, 0.0);
  RigidBodyDesc block = rigid(make_box({0.2, 0.05, 0.2}), 3.0, {0.0, 0.05, 0.0});
  block.friction = mu;
  block.velocity = {v, 0.0, 0.0};
  world.add_body(block);
  run(world, 0.5 * v / (mu * g), 1.0 / 240.0);
  const double t = world.time();
  EXPECT_NEAR(world.state(1).velocity.x(), v - mu * g * t, 1e-6);
  EXPECT_NEAR(world.pose(1).position.x(), v * t - 0.5 * mu * g * t * t, 1e-5);
  run(world, v / (mu * g), 1.0 / 240.0);
  EXPECT_NEAR(world.pose(1).position.x(), v * v / (2.0 * mu * g), 1e-3 * v * v / (2.0 * mu * g));
  EXPECT_LT(world.state(1).velocity.norm(), 1e-7);
  EXPECT_NEAR(world.pose(1).position.y(), 0.05, 1e-8);
}
INSTANTIATE_TEST_SUITE_P(Friction, SlidingBlock, testing::Values(0.1, 0.3, 0.8));

TEST(Slope, HoldsBelowTheFrictionAngleAndSlidesAboveAtTheRightRate) {
  const double mu = 0.5;
  for (const double angle : {0.9 * std::atan(mu), 1.2 * std::atan(mu)}) {
    const Vec3 normal(std::sin(angle), std::cos(angle), 0.0), down(std::cos(angle), -std::sin(angle), 0.0);
    RigidWorld world = world_with_floor(mu, 0.0, normal);
    RigidBodyDesc block = rigid(make_box({0.2, 0.05, 0.2}), 2.0, 0.05 * normal);
    block.friction = mu;
    block.pose.orientation = rotation_exp({0.0, 0.0, -angle});
    world.add_body(block);
    run(world, 1.0, h);
    const double acceleration = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
    EXPECT_NEAR((world.pose(1).position - block.pose.position).dot(down), 0.5 * acceleration, 1e-6);
    EXPECT_NEAR(world.state(1).velocity.dot(down), acceleration, 1e-6);
  }
}

/// How a ball on the ground, and one above it, answer to a small wrench: as finite differences have it. On
/// the ground it rolls.
TEST(Compliance, IsTheDerivativeOfThePredictedPose) {
  for (const double height : {0.1, 0.5}) {
    Eigen::Matrix<double, 6, 6> compliance;
    const double size = 1e-6;
    Eigen::Matrix<double, 6, 6> differences;
    for (int direction = -1; direction < 6; ++direction) {
      RigidWorld world = world_with_floor(0.5, 0.0);
      world.add_body(rigid(make_sphere(0.1), 2.0, {0.0, height, 0.0}));
      world.begin_step(h);
      world.solve();
      const Pose before = world.predicted_pose(1);
      if (direction < 0) {
        compliance = world.compliance(1);
        continue;
      }
      Vec3 push = Vec3::Zero(), moment = Vec3::Zero();
      (direction < 3 ? push : moment)[direction % 3] = size;
      world.apply_wrench(1, world.pose(1).position, push / h, moment / h);
      world.solve();
      const Pose after = world.predicted_pose(1);
      differences.col(direction) << (after.position - before.position) / size,
          rotation_log(after.orientation * before.orientation.conjugate()) / size;
    }
    EXPECT_LT((compliance - differences).norm(), 1e-3 * differences.norm()) << compliance << "\n\n"
                                                                            << differences;
  }
}

TEST(BouncingBall, RisesToTheSquareOfTheRestitution) {
  for (const double e : {0.3, 0.7, 0.95, 1.0}) {
    RigidWorld world = world_with_floor(0.3, e);
    world.add_body(rigid(make_sphere(0.1), 1.0, {0.0, 1.1, 0.0}));
    const double fall = std::sqrt(2.0 / g);
    double highest = 0.0;
    while (world.time() < fall * (1.0 + 1.9 * e)) {
      world.step(h);
      if (world.time() > fall + h) highest = std::max(highest, world.pose(1).position.y() - 0.1);
    }
    // Sampled at the steps: the top lies at most h/2 away from one.
    EXPECT_NEAR(highest, e * e, 0.5 * g * h * h / 4.0 + 1e-9);
    EXPECT_LE(highest, e * e + 1e-9);
  }
}

TEST(BouncingBall, ElasticOneKeepsItsEnergyOverManyBounces) {
  RigidWorld world = world_with_floor(0.0, 1.0);
  world.add_body(rigid(make_sphere(0.1), 2.0, {0.0, 1.1, 0.0}));
  const double energy = world.kinetic_energy() + world.gravity_energy();
  run(world, 10.0, h);
  EXPECT_NEAR((world.kinetic_energy() + world.gravity_energy()) / energy, 1.0, 1e-9);
}

TEST(Billiards, ObliqueShotPartsAtRightAnglesWithMomentumAndEnergyKept) {
  RigidWorld world;
  const double r = 0.03, offset = 0.02;  // of the centres across the line of flight
  RigidBodyDesc cue = rigid(make_sphere(r), 0.2, {-0.5, offset, 0.0}),
                target = rigid(make_sphere(r), 0.2, Vec3::Zero());
  cue.velocity = {5.0, 0.0, 0.0};
  for (RigidBodyDesc* ball : {&cue, &target}) {
    ball->restitution = 1.0;
    ball->friction = 0.0;
    world.add_body(*ball);
  }
  const Vec3 momentum = world.linear_momentum(), spin = world.angular_momentum();
  const double energy = world.kinetic_energy();
  run(world, 0.5, h);
  EXPECT_LT((world.linear_momentum() - momentum).norm(), 1e-14);
  EXPECT_LT((world.angular_momentum() - spin).norm(), 1e-14);
  EXPECT_NEAR(world.kinetic_energy(), energy, 1e-13);
  // The target leaves along the line of centres, the cue ball across it.
  const double sine = offset / (2.0 * r), cosine = std::sqrt(1.0 - sine * sine);
  EXPECT_LT((world.state(1).velocity - 5.0 * cosine * Vec3(cosine, -sine, 0.0)).norm(), 1e-6);
  EXPECT_LT((world.state(0).velocity - 5.0 * sine * Vec3(sine, cosine, 0.0)).norm(), 1e-6);
}

TEST(Billiards, FrictionTurnsTheBallsAndKeepsAngularMomentum) {
  RigidWorld world;
  RigidBodyDesc a = rigid(make_sphere(0.03), 0.2, {-0.5, 0.02, 0.01}),
                b = rigid(make_box({0.05, 0.04, 0.03}), 0.3, Vec3::Zero());
  a.velocity = {7.0, 0.0, 0.0};
  a.angular_velocity = {3.0, 20.0, -10.0};
  b.angular_velocity = {1.0, 2.0, 3.0};
  for (const auto& body : {a, b}) world.add_body(body);
  const Vec3 momentum = world.linear_momentum(), spin = world.angular_momentum();
  const double energy = world.kinetic_energy();
  run(world, 0.5, h);
  EXPECT_LT((world.linear_momentum() - momentum).norm(), 1e-14);
  EXPECT_LT((world.angular_momentum() - spin).norm(), 1e-13);
  EXPECT_LT(world.kinetic_energy(), energy);
  EXPECT_GT(world.state(1).velocity.x(), 1.0);
}

TEST(RollingBall, SlipTurnsIntoRollingAtFiveSeventhsOfTheSpeed) {
  RigidWorld world = world_with_floor(0.2, 0.0);
  RigidBodyDesc ball = rigid(make_sphere(0.1), 1.0, {0.0, 0.1, 0.0});
  ball.friction = 0.2;
  ball.velocity = {2.0, 0.0, 0.0};
  world.add_body(ball);
  run(world, 2.0, h);
  EXPECT_NEAR(world.state(1).velocity.x(), 2.0 * 5.0 / 7.0, 1e-6);
  EXPECT_NEAR(world.state(1).angular_velocity().z(), -2.0 * 5.0 / 7.0 / 0.1, 1e-5);
}

class FastBody : public testing::TestWithParam<ShapeType> {};

TEST_P(FastBody, DoesNotPassThroughAThinPlate) {
  RigidWorld world;
  world.add_body(rigid(make_box({1.0, 0.001, 1.0}), std::nullopt, Vec3::Zero()));
  auto shape = GetParam() == ShapeType::sphere ? make_sphere(0.05)
               : GetParam() == ShapeType::box  ? make_box({0.05, 0.03, 0.04})
                                               : make_capsule(0.03, 0.05);
  RigidBodyDesc body = rigid(std::move(shape), 1.0, {0.1, 2.3, 0.05});
  body.velocity = {3.0, -100.0, 1.0};
  body.angular_velocity = {10.0, -7.0, 20.0};
  world.add_body(body);
  for (int i = 0; i < 60; ++i) {
    world.step(h);
    EXPECT_LT(world.metrics().max_penetration, 1e-7);
    EXPECT_TRUE(world.pose(1).position.y() > 0.0 || std::abs(world.pose(1).position.x()) > 1.0);
  }
}
INSTANTIATE_TEST_SUITE_P(Shapes, FastBody,
                         testing::Values(ShapeType::sphere, ShapeType::box, ShapeType::capsule));

}  // namespace
}  // namespace isochor
