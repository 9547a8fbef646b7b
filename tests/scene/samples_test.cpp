#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/dynamics/cell_volume.h"
#include "core/scene/read_scene.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

class Samples : public testing::TestWithParam<std::string> {};

double largest_cell_error(const BodyTopology& body, const std::vector<Vec3>& positions) {
  double largest = 0.0;
  for (const Cell& cell : body.mesh->cells) {
    CellCorners now, rest;
    for (int b = 0; b < 8; ++b) {
      now[b] = positions[cell.corners[b]];
      rest[b] = body.rest_positions[cell.corners[b]];
    }
    const double volume = cell_volume(rest, cell.parity());
    largest = std::max(largest, std::abs(cell_volume(now, cell.parity()) - volume) / volume);
  }
  return largest;
}

std::int64_t inverted_tets(const BodyTopology& body, const std::vector<Vec3>& x) {
  return std::ranges::count_if(
      body.mesh->tets, [&](const Tet& t) { return tet_volume(x[t[0]], x[t[1]], x[t[2]], x[t[3]]) <= 0.0; });
}

/// Edge length of the smallest cell at rest; a tenth of a metre for rigid bodies alone.
double smallest_cell(const std::vector<BodyTopology>& topology) {
  double smallest = 0.1;
  for (const BodyTopology& body : topology)
    if (body.deformable) smallest = std::min(smallest, body.scale * body.mesh->grid.spacing);
  return smallest;
}

/// Volumes are computed here from the positions, not taken from the metrics.
TEST_P(Samples, KeepsTheVolumeOfEveryCell) {
  Progress quiet;
  Scene scene = read_scene_file(std::filesystem::path(ISOCHOR_SAMPLES) / "scenes" / (GetParam() + ".json"));
  scene.duration = std::min(scene.duration.value_or(1.0), 1.0);
  const auto simulation = compile(scene, quiet);
  const std::vector<BodyTopology> topology = simulation->topology();
  Snapshot frame = simulation->snapshot();
  const Vec3 linear = frame.metrics.linear_momentum, angular = frame.metrics.angular_momentum;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    EXPECT_TRUE(frame.metrics.feasible) << "t = " << frame.t;
    EXPECT_LE(frame.metrics.max_penetration, 1e-3 * smallest_cell(topology)) << "t = " << frame.t;
    double error = 0.0;
    bool deformable = false;
    for (const BodyTopology& body : topology) {
      if (!body.deformable) continue;
      deformable = true;
      error = std::max(error, largest_cell_error(body, frame.bodies[body.id].positions));
    }
    ASSERT_LE(error, scene.solver.tolerance * 1.01) << "t = " << frame.t;
    if (deformable) {
      EXPECT_NEAR(error, frame.metrics.max_cell_volume_error, 1e-12);
    }
  }
  for (const BodyTopology& body : topology) {
    if (!body.deformable) continue;
    EXPECT_EQ(inverted_tets(body, frame.bodies[body.id].positions), 0);
  }
  const bool alone = scene.bodies.size() == 1 && scene.pins.empty() && scene.gravity.isZero();
  if (alone) {
    EXPECT_LT((frame.metrics.linear_momentum - linear).norm(), 1e-10 * std::max(1.0, linear.norm()));
    EXPECT_LT((frame.metrics.angular_momentum - angular).norm(), 1e-10 * std::max(1.0, angular.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Samples,
                         testing::Values("ball_on_cube", "billiard", "chain", "cube_on_torus", "dumbbell",
                                         "drop", "fold", "soft_stack", "spin", "twist", "squash", "tree",
                                         "sphere_meets_strong_cube", "sphere_meets_weak_cube"),
                         [](const auto& test) { return test.param; });

/// What a scene does not use holds no memory and takes no time.
TEST(Plan, WhatIsLeftOutIsAbsent) {
  Progress quiet;
  for (const char* name : {"spin", "drop", "squash"}) {
    Scene scene =
        read_scene_file(std::filesystem::path(ISOCHOR_SAMPLES) / "scenes" / (std::string(name) + ".json"));
    scene.duration = 0.1;
    const auto simulation = compile(scene, quiet);
    while (!simulation->finished()) simulation->step(quiet);
    std::set<std::string> included;
    for (const PlannedPhase& phase : simulation->plan()) {
      EXPECT_FALSE(phase.reason.empty()) << phase.name;
      if (phase.included) {
        included.insert(phase.name);
      } else {
        EXPECT_EQ(phase.bytes, 0) << name << " " << phase.name;
        EXPECT_EQ(phase.ms, 0.0) << name << " " << phase.name;
      }
    }
    EXPECT_EQ(included.contains("contacts"), std::string(name) != "spin") << name;
    EXPECT_EQ(included.contains("gravity"), !scene.gravity.isZero()) << name;
  }
}

}  // namespace
}  // namespace isochor
