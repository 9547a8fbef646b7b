#include <gtest/gtest.h>

#include "core/scene/read_scene.h"
#include "core/scene/simulation.h"
#include "tests/scene/scenes.h"

namespace isochor {
namespace {

std::unique_ptr<Simulation> compile_text(const std::string& json) {
  Progress quiet;
  return compile(read_scene(json, "."), quiet);
}

const std::string bodies = R"(
  {"name":"cube","type":"deformable","lattice":{"cells":[4,4,4],"cell_size":0.1,"origin":[-0.2,1,-0.2]},
   "edge_stiffness":300,"diagonal_stiffness":100,"angular_velocity":[0,3,1]},
  {"name":"crate","type":"rigid","shape":{"box":{"half_extents":[0.1,0.1,0.1]}},"mass":2,"position":[2,1,0],
   "velocity":[0,2,0],"angular_velocity":[1,2,3]},
  {"name":"lift","type":"rigid","shape":{"box":{"half_extents":[0.1,0.1,0.1]}},"position":[5,0,0],
   "motion":{"velocity":[0,1,0]}})";

std::string scene_with(const std::string& more) {
  return R"({"duration":null,"bodies":[)" + bodies + more + "]}";
}

void step(Simulation& simulation, int frames) {
  Progress quiet;
  for (int k = 0; k < frames; ++k) simulation.step(quiet);
}

TEST(ContinuedRun, GoesOnAsTheRunBeforeWouldHave) {
  // Each run has its own first guesses, so they agree to the tolerance.
  const std::string exact = R"({"solver":{"tolerance":1e-9},)" + scene_with("").substr(1);
  const auto before = compile_text(exact), after = compile_text(exact);
  step(*before, 12);
  after->continue_from(*before);
  step(*before, 12);
  step(*after, 12);
  const Snapshot a = before->snapshot(), b = after->snapshot();
  EXPECT_EQ(a.seq, b.seq);
  for (std::size_t i = 0; i < a.bodies[0].positions.size(); ++i)
    EXPECT_LT((a.bodies[0].positions[i] - b.bodies[0].positions[i]).norm(), 1e-9);
  for (const int rigid : {1, 2}) {
    EXPECT_LT((a.bodies[rigid].position - b.bodies[rigid].position).norm(), 1e-12);
    EXPECT_LT(a.bodies[rigid].orientation.angularDistance(b.bodies[rigid].orientation), 1e-12);
  }
}

TEST(ContinuedRun, WhatIsAddedOnTheWayIsMet) {
  const auto before = compile_text(scene_with(""));
  step(*before, 6);
  const auto after = compile_text(scene_with(
      R"(,{"name":"ball","type":"rigid","shape":{"sphere":{"radius":0.3}},"static":true,"position":[0,0.1,0]})"));
  after->continue_from(*before);
  EXPECT_EQ(after->snapshot().seq, 6);
  EXPECT_EQ(after->snapshot().bodies.size(), 4u);
  step(*before, 40);
  std::int64_t contacts = 0;
  for (int k = 0; k < 40; ++k) {
    step(*after, 1);
    contacts += after->snapshot().metrics.contacts;
    EXPECT_LE(after->snapshot().metrics.max_cell_volume_error, 1e-6);
  }
  EXPECT_GT(contacts, 0);
  EXPECT_GT(after->snapshot().bodies[0].positions[0].y(),
            before->snapshot().bodies[0].positions[0].y() + 0.3);
}

/// A modulus is a stiffness a metre of cell, also when it comes while the scene runs.
TEST(LiveMaterial, AModulusIsTheStiffnessOfACellsSize) {
  Progress quiet;
  const Scene scene = isochor::testing::stretched_cube(4, 1e3, 1.0 / 60.0, SpringIntegrator::automatic);
  const auto by_modulus = compile(scene, quiet), by_stiffness = compile(scene, quiet);
  SpringSettings given;
  given.edge_modulus = 4e4, given.diagonal_modulus = 0.0;
  by_modulus->set_material(0, given);
  given = {};
  given.edge_stiffness = 1e4, given.diagonal_stiffness = 0.0;
  by_stiffness->set_material(0, given);
  EXPECT_EQ(by_modulus->step(quiet).metrics.potential_energy,
            by_stiffness->step(quiet).metrics.potential_energy);
}

}  // namespace
}  // namespace isochor
