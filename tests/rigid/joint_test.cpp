#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/rigid/worlds.h"

namespace isochor {
namespace {

constexpr double g = 9.81, h = 1.0 / 60.0;

/// Links of a metre along x, the first held at the origin by the body 0.
RigidWorld chain(int links, double ratio = 1.0) {
  RigidWorld world;
  world.set_gravity({0.0, -g, 0.0});
  world.add_body(rigid(make_sphere(0.01), std::nullopt, Vec3::Zero()));
  double mass = 1.0;
  for (int i = 0; i < links; ++i, mass *= ratio) {
    world.add_body(rigid(make_box({0.2, 0.05, 0.05}), mass, {i + 0.5, 0.0, 0.0}));
    world.add_joint({JointKind::ball, i, i + 1, Vec3(i, 0.0, 0.0)});
  }
  return world;
}

double energy(const RigidWorld& world) {
  return world.kinetic_energy() + world.gravity_energy();
}

TEST(Joint, ChainOfTenSwingsWithoutComingApart) {
  RigidWorld world = chain(10);
  const double start = energy(world);
  double error = 0.0;
  for (int step = 0; step < 600; ++step) {
    world.step(h);
    error = std::max(error, world.metrics().max_joint_error);
    EXPECT_TRUE(world.metrics().converged);
    // Of the 490 J that the swing is about; links that fold onto each other may lose some.
    ASSERT_LT(energy(world) - start, 0.5);
    ASSERT_TRUE(world.time() > 4.0 || energy(world) - start > -0.5);
  }
  EXPECT_LT(error, 1e-9);
}

TEST(Joint, HeavyEndOfAChainDoesNotStretchIt) {
  for (const double ratio : {1e6, 1e-6}) {
    RigidWorld world = chain(2, ratio);
    double error = 0.0;
    for (int step = 0; step < 240; ++step) {
      world.step(h);
      error = std::max(error, world.metrics().max_joint_error);
    }
    EXPECT_LT(error, 1e-8);
  }
}

TEST(Joint, PendulumHasTheClosedFormulasPeriod) {
  // A box on a hinge: T = 2π√(I/(m g d)) for small swings.
  RigidWorld world;
  world.set_gravity({0.0, -g, 0.0});
  world.add_body(rigid(make_sphere(0.01), std::nullopt, Vec3::Zero()));
  const double angle = 1e-3, d = 0.6;
  RigidBodyDesc bob =
      rigid(make_box({0.1, 0.2, 0.15}), 2.0, {d * std::sin(angle), -d * std::cos(angle), 0.0});
  bob.pose.orientation = rotation_exp({0.0, 0.0, angle});
  world.add_body(bob);
  world.add_joint({JointKind::hinge, 0, 1, Vec3::Zero(), Vec3::UnitZ()});
  const double inertia = (0.01 + 0.04) / 3.0 + d * d,
               period = 2.0 * std::numbers::pi * std::sqrt(inertia / (g * d));
  double previous = world.pose(1).position.x(), first = 0.0, last = 0.0;
  int crossings = 0;
  while (crossings < 11) {
    world.step(1.0 / 240.0);
    const double x = world.pose(1).position.x();
    if (previous > 0.0 && x <= 0.0) {
      last = world.time() - x / (x - previous) / 240.0;
      if (crossings++ == 0) first = last;
    }
    previous = x;
    ASSERT_LT(world.time(), 60.0);
  }
  EXPECT_NEAR((last - first) / 10.0 / period, 1.0, 1e-4);
}

TEST(Joint, HingeKeepsItsAxisAndFixedItsAngle) {
  for (const JointKind kind : {JointKind::hinge, JointKind::fixed}) {
    RigidWorld world;
    RigidBodyDesc a = rigid(make_box({0.2, 0.1, 0.1}), 1.0, {-0.3, 0.0, 0.0});
    RigidBodyDesc b = rigid(make_box({0.2, 0.1, 0.3}), 3.0, {0.3, 0.0, 0.0});
    a.angular_velocity = {2.0, 1.0, 5.0};
    b.velocity = {0.0, 0.0, 1.0};
    world.add_body(a), world.add_body(b);
    world.add_joint({kind, 0, 1, Vec3::Zero(), Vec3(0.0, 1.0, 0.2)});
    world.step(h);  // the start does not meet the joint's velocities
    const Vec3 momentum = world.linear_momentum(), spin = world.angular_momentum();
    const double start = world.kinetic_energy();
    double error = 0.0;
    for (int step = 0; step < 600; ++step) {
      world.step(h);
      error = std::max(error, world.metrics().max_joint_error);
    }
    EXPECT_LT(error, 1e-9);
    EXPECT_LT((world.linear_momentum() - momentum).norm(), 1e-12);
    EXPECT_LT((world.angular_momentum() - spin).norm(), 1e-9);
    EXPECT_NEAR(world.kinetic_energy() / start, 1.0, 0.01);
  }
}

TEST(Joint, ACycleOfHingesHolds) {
  // Four bars on parallel hinges: more equations than freedoms, which must not matter.
  RigidWorld world;
  world.set_gravity({0.0, -g, 0.0});
  world.add_body(rigid(make_box({1.0, 0.05, 0.05}), std::nullopt, {0.0, 0.0, 0.0}));
  world.add_body(rigid(make_box({0.05, 0.5, 0.05}), 1.0, {-1.0, -0.5, 0.0}));
  world.add_body(rigid(make_box({1.0, 0.05, 0.05}), 2.0, {0.0, -1.0, 0.0}));
  RigidBodyDesc last = rigid(make_box({0.05, 0.5, 0.05}), 1.0, {1.0, -0.5, 0.0});
  world.add_body(last);
  const Vec3 corners[] = {{-1.0, 0.0, 0.0}, {-1.0, -1.0, 0.0}, {1.0, -1.0, 0.0}, {1.0, 0.0, 0.0}};
  for (int i = 0; i < 4; ++i) world.add_joint({JointKind::hinge, i, (i + 1) % 4, corners[i], Vec3::UnitZ()});
  world.begin_step(h);
  world.apply_impulse(2, {0.0, -1.0, 0.0}, {4.0, 0.0, 0.0});
  world.solve();
  world.end_step();
  const double start = energy(world);
  double error = 0.0, swing = 0.0;
  for (int step = 0; step < 600; ++step) {
    world.step(h);
    error = std::max(error, world.metrics().max_joint_error);
    swing = std::max(swing, world.pose(2).position.x());
  }
  EXPECT_LT(error, 1e-8);
  EXPECT_GT(swing, 0.3);
  EXPECT_NEAR(energy(world), start, 0.02 * std::abs(start));
}

}  // namespace
}  // namespace isochor
