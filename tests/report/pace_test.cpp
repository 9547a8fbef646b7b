#include "core/report/pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/report/meshing_report.h"
#include "core/report/scene_settings.h"

namespace isochor {
namespace {

using CostOf = std::function<double(const SceneSettings&)>;

std::vector<SceneSettings> usual_grid() {
  std::vector<SceneSettings> grid;
  for (VolumeSolver solver : {VolumeSolver::newton, VolumeSolver::gradient, VolumeSolver::scaling})
    for (double resolution : {0.5, 1.0})
      for (double tolerance : {1e-2, 1e-4, 1e-6})
        for (int substeps : {4, 8, 16, 32})
          grid.push_back({solver, SpringIntegrator::symplectic, substeps, tolerance, resolution});
  return grid;
}

/// The largest factor between what is said to be left and what is, from this share of the run's time on, as
/// long as a twentieth of it is left; asked at the start of each run and in its middle.
double worst_estimate(const std::vector<SceneSettings>& grid, const CostOf& cost, double from) {
  constexpr int repeats = 3;
  SceneSettings reference = grid.back();
  reference.solver = VolumeSolver::newton, reference.substeps *= 16, reference.tolerance = 1e-10;
  std::vector<CostPlace> places;
  for (const SceneSettings& settings : grid) places.push_back(cost_place(settings));
  double whole = cost(reference), spent = 0.0, worst = 1.0;
  Pace pace;
  pace.expect(cost_place(reference), 1);
  for (std::size_t i = 0; i < grid.size(); ++i)
    pace.expect(places[i], repeats), whole += repeats * cost(grid[i]);

  const auto run = [&](const CostPlace& place, double seconds) {
    for (double share : {0.0, 0.5}) {
      const double now = spent + share * seconds, fraction = pace.fraction(place, share, share * seconds);
      if (now < from * whole || now > 0.95 * whole) continue;
      const double said = now * (1.0 - fraction) / fraction, left = whole - now;
      worst = std::max({worst, said / left, left / said});
    }
    pace.end_run(place, seconds), spent += seconds;
  };
  run(cost_place(reference), cost(reference));
  for (std::size_t i : revealing_order(places))
    for (int repeat = 0; repeat < repeats; ++repeat) run(places[i], cost(grid[i]));
  return worst;
}

double decades(const SceneSettings& settings) {
  return -std::log10(settings.tolerance);
}

/// Of a scene: those of the sweeping solvers grow with more than the cells, and end at their iteration limit.
double hard_last(const SceneSettings& s) {
  const double cells = std::pow(8.0 * s.resolution, 3);
  if (s.solver == VolumeSolver::newton) return 1e-5 * cells * (20 + s.substeps) * (1.0 + 0.2 * decades(s));
  const double sweeps = std::min(1000.0, std::exp(0.9 * decades(s)) * (1.0 + cells / 100.0));
  return (s.solver == VolumeSolver::scaling ? 3e-6 : 1e-6) * cells * s.substeps * (2.0 + sweeps);
}

TEST(Pace, EstimatesWithinAFactorOfTwoFromAQuarterOn) {
  const std::vector<SceneSettings> grid = usual_grid();
  EXPECT_LT(worst_estimate(grid, hard_last, 0.25), 2.0);
  const auto noisy = [](const SceneSettings& s) {
    return hard_last(s) * (1.0 + 0.3 * std::sin(100.0 * s.substeps + 7.0 * decades(s) + s.resolution));
  };
  EXPECT_LT(worst_estimate(grid, noisy, 0.25), 2.0);
  const auto slow_solver = [](const SceneSettings& s) {  // a hundred times slower than is usual
    return hard_last(s) * (s.solver == VolumeSolver::scaling ? 100.0 : 1.0);
  };
  EXPECT_LT(worst_estimate(grid, slow_solver, 0.25), 2.0);
  const auto dear_coarse_steps = [](const SceneSettings& s) {  // impacts that few substeps resolve badly
    return hard_last(s) * std::pow(s.substeps, -1.2) * 30.0;
  };
  EXPECT_LT(worst_estimate(grid, dear_coarse_steps, 0.25), 2.0);
}

TEST(Pace, ProductsOfPowersAreKnownFromAnyPlace) {
  const std::vector<SceneSettings> grid = usual_grid();
  CostModel model;
  const auto cost = [](const SceneSettings& s) { return s.substeps * std::pow(s.resolution, 4); };
  std::vector<CostPlace> places;
  for (const SceneSettings& settings : grid) places.push_back(cost_place(settings));
  const std::vector<std::size_t> order = revealing_order(places);
  for (std::size_t k = 0; k < 15; ++k) model.add(places[order[k]], cost(grid[order[k]]));  // 5 a solver
  for (std::size_t i = 0; i < grid.size(); ++i)
    EXPECT_NEAR(std::log(model.predict(places[i]) / cost(grid[i])), 0.0, std::log(1.35));
}

TEST(Pace, TheFirstRunIsWhatTheOthersArePredictedFrom) {
  const CostPlace reference{0, 0, {3.0}, 3.0}, point{0, 0, {1.0}, 1.0};
  Pace pace;
  pace.expect(reference, 1), pace.expect(point, 2);
  EXPECT_EQ(pace.fraction(reference, 0.0, 0.0), 0.0);
  const double whole = 1.0 + 2.0 * std::exp(-2.0);
  EXPECT_NEAR(pace.fraction(reference, 0.5, 0.5), 0.5 / whole, 0.05);
  pace.end_run(reference, 1.0);
  EXPECT_NEAR(pace.fraction(point, 0.0, 0.0), 1.0 / whole, 0.05);
  pace.end_run(point, 1.0);
  EXPECT_NEAR(pace.fraction(point, 0.5, 0.5), 2.5 / 3.0, 1e-12);
  pace.leave_out(point);
  EXPECT_NEAR(pace.fraction(point, 0.0, 0.0), 1.0, 1e-12);
}

TEST(Pace, AReferenceThatBlowsUpLeavesTheOthersWhatTheyTake) {
  const CostPlace reference{0, 0, {3.0}, 3.0}, first{0, 0, {1.0}, 1.0}, next{0, 0, {2.0}, 2.0};
  Pace pace;
  pace.expect_reference(reference), pace.expect(first, 1), pace.expect(next, 1);
  pace.end_run(reference, 0.01, 1.0);
  const double of_first = std::exp(-2.0), of_next = std::exp(-1.0);
  EXPECT_NEAR(pace.fraction(first, 0.0, 0.0), 0.01 / (0.01 + of_first + of_next), 0.005);
  pace.end_run(first, of_first);
  const double spent = 0.01 + of_first;
  EXPECT_NEAR(pace.fraction(next, 0.0, 0.0), spent / (spent + of_next), 0.03);
}

TEST(Pace, PointsThatBlowUpLetOthersOfTheirKindBeExpectedTo) {
  Pace pace;
  const auto place = [](int method, double x) { return CostPlace{method, 0, {x}, x}; };
  for (int method : {0, 1})
    for (int k = 0; k < 4; ++k) pace.expect(place(method, k), 2);
  for (int k = 0; k < 3; ++k) {
    pace.end_run(place(0, k), std::exp(k)), pace.end_run(place(0, k), std::exp(k));
    pace.end_run(place(1, k), 0.01 * std::exp(k), std::exp(k));
  }
  const double spent = 2.01 * (1.0 + std::exp(1.0) + std::exp(2.0)), whole = 2.0 * std::exp(3.0);
  const double left = spent / pace.fraction(place(1, 3), 0.0, 0.0) - spent;
  EXPECT_GT(left, whole);
  EXPECT_LT(left, 1.2 * whole);
}

TEST(Pace, APauseOfTheMachineIsForgottenAfterARepeat) {
  const CostPlace first{0, 0, {0.0}, 0.0}, next{0, 0, {1.0}, 1.0};
  CostModel model;
  model.add(first, 30.0);
  EXPECT_NEAR(model.predict(next), 30.0 * std::exp(1.0), 5.0);
  model.add(first, 0.5);
  EXPECT_NEAR(model.predict(next), 0.5 * std::exp(1.0), 0.1);
  model.add(first, 20.0);
  EXPECT_NEAR(model.predict(next), 0.5 * std::exp(1.0), 0.1);
}

TEST(Pace, SlowPointsAreExpectedOnce) {
  const CostPlace quick{0, 0, {0.0}, 0.0}, slow{0, 0, {5.0}, 5.0};
  Pace pace(10.0);
  pace.know(quick, 1.0);
  pace.expect(slow, 3);
  const double whole = std::sqrt(std::exp(5.0) * 100.0);  // half of it predicted, half by its own pace
  EXPECT_NEAR(pace.fraction(slow, 0.5, 50.0), 50.0 / whole, 0.02);
  EXPECT_GT(pace.fraction(slow, 0.99, 100.0), 0.98);
}

TEST(Pace, CheapRunsComeFirstThenFarCornersThenTheGrid) {
  const std::vector<SceneSettings> grid = usual_grid();
  std::vector<CostPlace> places;
  for (const SceneSettings& settings : grid) places.push_back(cost_place(settings));
  const std::vector<std::size_t> order = revealing_order(places);
  ASSERT_EQ(order.size(), grid.size());
  EXPECT_EQ(std::vector<std::size_t>(order.begin(), order.begin() + 3),
            (std::vector<std::size_t>{0, 48, 24}));
  EXPECT_EQ(std::vector<std::size_t>(order.begin() + 12, order.begin() + 15),
            (std::vector<std::size_t>{23, 71, 47}));
  EXPECT_TRUE(std::ranges::is_sorted(order.begin() + 15, order.end()));
}

TEST(Pace, OfMeshesIsKnownFromTheFirstPoints) {
  MeshingReportOptions options;
  options.axes = usual_meshing_axes(options.base);
  const std::vector<MeshingOptions> grid = meshing_grid(options);
  CostModel model;
  std::vector<CostPlace> places;
  for (const MeshingOptions& settings : grid) places.push_back(cost_place(settings));
  const auto cost = [](const MeshingOptions& o) {
    return 0.03 + 1e-5 * std::pow(o.voxels, 1.3) * std::pow(o.lattice.cells, 0.3) *
                      (1.0 + 0.1 * o.smoothing.iterations);
  };
  const std::vector<std::size_t> order = revealing_order(places);
  double whole = 0.0, predicted = 0.0;
  for (std::size_t k = 0; k < order.size() / 4; ++k) model.add(places[order[k]], cost(grid[order[k]]));
  for (std::size_t i = 0; i < grid.size(); ++i) whole += cost(grid[i]), predicted += model.predict(places[i]);
  EXPECT_NEAR(predicted / whole, 1.0, 0.2);
}

double left(const Pace& pace, const CostPlace& place, double seconds, double lost) {
  const double fraction = pace.fraction(place, 0.5, seconds + lost, lost);
  return (seconds + lost) * (1.0 - fraction) / fraction;
}

TEST(Pace, AFrameThatStallsIsNotForeseenAgain) {
  const auto grid = usual_grid();
  Pace pace;
  for (const SceneSettings& settings : grid) pace.expect(cost_place(settings), 3);
  const CostPlace first = cost_place(grid.front());
  EXPECT_NEAR(left(pace, first, 5.0, 30.0), left(pace, first, 5.0, 0.0), 1e-6);

  Stalls stalls;
  for (int frame = 0; frame < 50; ++frame) stalls.add(frame == 20 ? 30.0 : 0.1);
  EXPECT_NEAR(stalls.lost(), 29.0, 1e-9);
}

TEST(Pace, FramesThatGrowDearerAreNoStalls) {
  Stalls stalls;
  double whole = 0.0;
  for (int frame = 0; frame < 100; ++frame) {
    const double seconds = frame < 20 ? 0.001 : 0.5;
    stalls.add(seconds), whole += seconds;
  }
  EXPECT_LT(stalls.lost(), 0.1 * whole);
}

}  // namespace
}  // namespace isochor
