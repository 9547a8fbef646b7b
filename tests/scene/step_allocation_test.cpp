#include <gtest/gtest.h>

#include "core/parallel/parallel.h"
#include "core/scene/simulation.h"
#include "tests/scene/scenes.h"
#include "tests/support/counted_new.h"

namespace isochor {
namespace {

using isochor::testing::stretched_cube;

/// On the ground under gravity, with friction: every phase of a substep is warm after a few frames.
TEST(StepAllocation, AWarmStepAllocatesNothing) {
  Progress quiet;
  set_thread_count(1);
  for (const SpringIntegrator springs :
       {SpringIntegrator::symplectic, SpringIntegrator::implicit, SpringIntegrator::energy_momentum}) {
    Scene scene = stretched_cube(4, 1e4, 1.0 / 60.0, springs);
    scene.gravity = Vec3(0.0, -9.81, 0.0);
    scene.bodies[0].position = Vec3(0.0, 0.5, 0.0);
    RigidBody ground;
    ground.shape = PlaneShape{};
    ground.is_static = true;
    scene.bodies.emplace_back();
    scene.bodies[1].name = "ground";
    scene.bodies[1].kind = ground;
    const auto simulation = compile(scene, quiet);
    for (int i = 0; i < 10; ++i) simulation->advance(quiet);
    const std::int64_t before = allocations.load();
    for (int i = 0; i < 10; ++i) simulation->advance(quiet);
    EXPECT_EQ(allocations.load() - before, 0) << static_cast<int>(springs);
  }
  set_thread_count(0);
}

/// The same with a second cube on the first one, which may meet itself.
TEST(StepAllocation, AWarmCollisionAllocatesNothing) {
  Progress quiet;
  set_thread_count(1);
  Scene scene = stretched_cube(3, 1e4, 1.0 / 60.0, SpringIntegrator::automatic);
  std::get<DeformableBody>(scene.bodies[0].kind).damping = 0.02;
  scene.gravity = Vec3(0.0, -9.81, 0.0);
  scene.bodies.push_back(scene.bodies[0]);
  scene.bodies[1].name = "lower";
  scene.bodies[1].position = Vec3(0.1, -1.01, 0.0);
  std::get<DeformableBody>(scene.bodies[1].kind).self_contact = true;
  AxisBox bottom;
  bottom.max.y() = -1.4;
  scene.pins.push_back({"lower", bottom, std::nullopt});
  const auto simulation = compile(scene, quiet);
  for (int i = 0; i < 90; ++i) simulation->advance(quiet);
  const std::int64_t before = allocations.load();
  for (int i = 0; i < 5; ++i) simulation->advance(quiet);
  EXPECT_EQ(allocations.load() - before, 0);
  EXPECT_GT(simulation->snapshot().metrics.contacts, 8);
  set_thread_count(0);
}

}  // namespace
}  // namespace isochor
