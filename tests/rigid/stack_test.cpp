#include <gtest/gtest.h>

#include "tests/rigid/worlds.h"

namespace isochor {
namespace {

constexpr double h = 1.0 / 60.0;

struct StackCase {
  const char* name;
  int count;
  double ratio;  ///< mass of each box against the one below
};
void PrintTo(const StackCase& stack, std::ostream* out) {
  *out << stack.name;
}

class Stack : public testing::TestWithParam<StackCase> {};

TEST_P(Stack, StandsForTenSecondsWhereItWasPut) {
  RigidWorld world = world_with_floor(0.3, 0.0);
  double mass = 1.0;
  for (int i = 0; i < GetParam().count; ++i, mass *= GetParam().ratio)
    world.add_body(rigid(make_box({0.5, 0.25, 0.5}), mass, {0.01 * (i % 2), 0.25 + 0.5 * i, 0.0}));
  int iterations = 0;
  double penetration = 0.0;
  for (int step = 0; step < 600; ++step) {
    world.step(h);
    iterations += world.metrics().iterations;
    penetration = std::max(penetration, world.metrics().max_penetration);
  }
  for (int i = 0; i < GetParam().count; ++i) {
    EXPECT_LT((world.pose(i + 1).position - Vec3(0.01 * (i % 2), 0.25 + 0.5 * i, 0.0)).norm(), 1e-7);
    EXPECT_LT(world.state(i + 1).velocity.norm(), 1e-7);
    EXPECT_LT(world.pose(i + 1).orientation.angularDistance(Eigen::Quaterniond::Identity()), 1e-7);
  }
  EXPECT_LT(penetration, 1e-8);
  RecordProperty("iterations", iterations);
}
INSTANTIATE_TEST_SUITE_P(Heights, Stack,
                         testing::Values(StackCase{"five", 5, 1.0}, StackCase{"ten", 10, 1.0},
                                         StackCase{"million_to_one", 2, 1e6},
                                         StackCase{"ten_times_each", 7, 10.0},
                                         StackCase{"lighter_upwards", 7, 0.1}));

class DroppedBoxes : public testing::TestWithParam<double> {};

/// However little they are turned more or less: where edges cross, the normal turns with the boxes.
TEST_P(DroppedBoxes, ComeToRestOnEachOther) {
  RigidWorld world = world_with_floor(0.5, 0.0);
  for (int i = 0; i < 5; ++i) {
    RigidBodyDesc box = rigid(make_box({0.3, 0.2, 0.3}), 1.0, {0.02 * i, 0.3 + 0.6 * i, 0.01 * i});
    box.pose.orientation = rotation_exp({0.02 * i, 0.1 * i, -(0.015 + GetParam()) * i});
    box.friction = 0.5;
    world.add_body(box);
  }
  double penetration = 0.0;
  int substeps = 0;
  for (int step = 0; step < 480; ++step) {
    substeps += world.step(h);
    penetration = std::max(penetration, world.metrics().max_penetration);
  }
  EXPECT_LT(substeps, 700);  // all but a few steps find a balance at once
  EXPECT_LT(penetration, 1e-6);
  EXPECT_LT(world.kinetic_energy(), 1e-12);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(world.pose(i + 1).position.y(), 0.2 + 0.4 * i, 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Turns, DroppedBoxes,
                         testing::Values(0.0, 1e-10, 1e-4, 1e-3, -1e-3, 5e-3, -5e-3, 0.01, -0.01, 0.02));

TEST(Stack, MixedShapesComeToRestOnTheFloor) {
  RigidWorld world = world_with_floor(0.5, 0.0);
  world.add_body(rigid(make_box({0.3, 0.2, 0.3}), 1.0, {0.0, 0.5, 0.0}));
  world.add_body(rigid(make_capsule(0.1, 0.2), 0.5, {0.02, 1.1, 0.0}));
  world.add_body(rigid(make_sphere(0.15), 0.7, {1.0, 0.5, 0.0}));
  const double start = world.gravity_energy();
  double highest = start;
  for (int step = 0; step < 600; ++step) {
    world.step(h);
    highest = std::max(highest, world.kinetic_energy() + world.gravity_energy());
    EXPECT_LT(world.metrics().max_penetration, 1e-5);
  }
  EXPECT_LT(highest, start + 1e-3);
  EXPECT_LT(world.kinetic_energy(), 1e-2);
}

}  // namespace
}  // namespace isochor
