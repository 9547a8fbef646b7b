#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/simulation.h"
#include "tests/scene/scenes.h"

namespace isochor {
namespace {

using isochor::testing::stretched_cube;

double energy(const Metrics& m) {
  return m.kinetic_energy + m.potential_energy;
}

class ImplicitStiffness : public ::testing::TestWithParam<double> {};

/// Released stretched at constant volume: finite, the volume kept, energy never above the start's.
TEST_P(ImplicitStiffness, NeverGainsEnergy) {
  for (const double h : {1e-5, 1e-3, 1.0 / 60.0, 0.1}) {
    Progress quiet;
    const auto simulation = compile(stretched_cube(3, GetParam(), h, SpringIntegrator::implicit), quiet);
    const double start = energy(simulation->snapshot().metrics);
    for (int frame = 0; frame < 20; ++frame) {
      const Metrics m = simulation->step(quiet).metrics;
      ASSERT_TRUE(std::isfinite(energy(m))) << "h = " << h;
      EXPECT_LE(energy(m), 1.05 * start + 1e-12) << "h = " << h << ", frame " << frame;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << "h = " << h;
      EXPECT_EQ(m.inverted, 0) << "h = " << h;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Stiffness, ImplicitStiffness, ::testing::Values(0.0, 1e3, 1e6, 1e9, 1e12));

TEST(Implicit, KeepsMomentumInFreeFlight) {
  Progress quiet;
  Scene scene = stretched_cube(4, 1e6, 1.0 / 60.0, SpringIntegrator::implicit);
  scene.bodies[0].velocity = Vec3(0.3, 0.2, 0.1);
  scene.bodies[0].angular_velocity = Vec3(1.0, 5.0, 3.0);
  const auto simulation = compile(scene, quiet);
  const Metrics start = simulation->snapshot().metrics;
  Metrics m;
  for (int frame = 0; frame < 60; ++frame) m = simulation->step(quiet).metrics;
  EXPECT_LT((m.linear_momentum - start.linear_momentum).norm(), 1e-10 * start.linear_momentum.norm());
  EXPECT_LT((m.angular_momentum - start.angular_momentum).norm(), 1e-10 * start.angular_momentum.norm());
}

/// A stiff body that spins keeps its shape and its spin: k = 1e10, ten radians a second.
TEST(Implicit, DoesNotGrowWithSpin) {
  Progress quiet;
  Scene scene = stretched_cube(3, 1e10, 1.0 / 60.0, SpringIntegrator::implicit);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
  scene.bodies[0].angular_velocity = Vec3(0.0, 0.0, 10.0);
  const auto simulation = compile(scene, quiet);
  const double start = energy(simulation->snapshot().metrics);
  Metrics m;
  for (int frame = 0; frame < 120; ++frame) m = simulation->step(quiet).metrics;
  EXPECT_NEAR(energy(m), start, 0.02 * start);
}

TEST(Implicit, AutoChoosesItWhereSymplecticStepsAreManyAndSaysWhy) {
  Progress quiet;
  for (const auto& [stiffness, implicit] : {std::pair{1e2, false}, {1e7, true}}) {
    const auto simulation =
        compile(stretched_cube(4, stiffness, 1.0 / 60.0, SpringIntegrator::automatic), quiet);
    for (const PlannedPhase& phase : simulation->plan()) {
      if (phase.name == "implicit_euler") {
        EXPECT_EQ(phase.included, implicit) << stiffness;
        EXPECT_EQ(phase.reason.find("Gershgorin") != std::string::npos, implicit) << phase.reason;
        EXPECT_EQ(phase.bytes > 0, implicit);
      }
      if (phase.name == "symplectic_euler") {
        EXPECT_EQ(phase.included, !implicit) << stiffness;
      }
    }
    EXPECT_EQ(simulation->step(quiet).metrics.substeps == 1, implicit || stiffness == 1e2);
  }
}

/// Σ m (r − R)·DR / Σ m |DR|², D = diag(1, −½, −½): how far the cube is stretched along x.
double stretch(const BodyTopology& body, const Snapshot& frame) {
  const Vec3 weights(1.0, -0.5, -0.5);
  double sum = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < body.masses.size(); ++i) {
    const Vec3 mode = weights.cwiseProduct(body.rest_positions[i]);
    sum += body.masses[i] * (frame.bodies[0].positions[i] - body.rest_positions[i]).dot(mode);
    norm += body.masses[i] * mode.squaredNorm();
  }
  return sum / norm;
}

/// Where implicit Euler has stopped it, the filtered leapfrog still swings, and never has more energy than at
/// its start.
TEST(EnergyMomentum, SwingsOnWithoutGainingEnergy) {
  Progress quiet;
  for (const SpringIntegrator springs : {SpringIntegrator::implicit, SpringIntegrator::energy_momentum}) {
    const auto simulation = compile(stretched_cube(4, 1e6, 1.0 / 60.0, springs), quiet);
    const BodyTopology body = simulation->topology()[0];
    Snapshot frame = simulation->snapshot();
    const double start = energy(frame.metrics), released = stretch(body, frame);
    double swing = 0.0;
    for (int i = 0; i < 66; ++i) {
      frame = simulation->step(quiet);
      EXPECT_LE(energy(frame.metrics), 1.01 * start);
      if (i > 54) swing = std::max(swing, std::abs(stretch(body, frame)) / released);
    }
    if (springs == SpringIntegrator::implicit)
      EXPECT_LT(swing, 0.01);
    else
      EXPECT_GT(swing, 0.4);
  }
}

/// At any stiffness, from a feasible start, at most the start's energy and one per cent.
TEST(EnergyMomentum, KeepsItsLedger) {
  Progress quiet;
  for (const double stiffness : {1e4, 1e8, 1e12}) {
    const auto simulation =
        compile(stretched_cube(3, stiffness, 1.0 / 60.0, SpringIntegrator::energy_momentum), quiet);
    const double start = energy(simulation->snapshot().metrics);
    for (int i = 0; i < 30; ++i) {
      const Metrics m = simulation->step(quiet).metrics;
      EXPECT_LE(energy(m), 1.01 * start) << stiffness << ", frame " << i;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << stiffness;
    }
  }
}

}  // namespace
}  // namespace isochor
