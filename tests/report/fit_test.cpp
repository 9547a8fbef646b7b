#include "core/report/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/report/scene_report.h"

namespace isochor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Fit, FindsTheKnownOrder) {
  const std::vector<double> x{0.5, 0.25, 0.125, 0.0625};
  for (double order : {1.0, 2.0, -0.5}) {
    std::vector<double> y;
    for (double value : x) y.push_back(3.0 * std::pow(value, order));
    ASSERT_TRUE(fit_order(x, y).has_value());
    EXPECT_NEAR(fit_order(x, y)->order, order, 1e-12);
  }
}

TEST(Fit, LeavesOutWhatHasNoLogarithm) {
  const std::vector<double> x{1.0, 0.5, 0.25, 0.125}, y{nan, 0.5, 0.0, 0.125};
  EXPECT_NEAR(fit_order(x, y)->order, 1.0, 1e-12);
  EXPECT_EQ(fit_order(x, y)->points, 2);
  const std::vector<double> one{0.5, 0.5}, two{1.0, 2.0};
  EXPECT_FALSE(fit_order(one, two).has_value());
}

TEST(Fit, MedianAndExtremes) {
  const Spread odd = spread_of({3.0, 1.0, 2.0}), even = spread_of({4.0, 1.0, 2.0, 3.0});
  EXPECT_EQ(odd.median, 2.0);
  EXPECT_EQ(odd.min, 1.0);
  EXPECT_EQ(odd.max, 3.0);
  EXPECT_EQ(even.median, 2.5);
  EXPECT_TRUE(std::isnan(spread_of({}).median));
}

TEST(Fit, QuantileIsTheSmallestThatTheShareKeepsTo) {
  std::vector<double> values;
  for (int i = 100; i > 0; --i) values.push_back(i);
  EXPECT_EQ(quantile(values, 0.95), 95.0);
  EXPECT_EQ(quantile(values, 1.0), 100.0);
  EXPECT_EQ(quantile({7.0}, 0.95), 7.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.95)));
}

TEST(Fit, FrontKeepsWhatNothingBeats) {
  const std::vector<double> cost{1.0, 2.0, 3.0, 2.5, nan, 4.0}, error{1.0, 0.5, 0.6, 0.5, 0.0, 0.1};
  EXPECT_EQ(pareto_front(cost, error), (std::vector<std::size_t>{0, 1, 5}));
}

ScenePoint planted(int substeps, double tolerance, double error) {
  ScenePoint point;
  point.settings.substeps = point.substeps = substeps;
  point.settings.tolerance = tolerance;
  point.errors.trajectory_rms = error;
  point.ms_per_step = {static_cast<double>(substeps), 0.0, 0.0};
  point.ms_p95 = 1.5 * substeps;
  return point;
}

TEST(SceneOrders, AreFittedASeries) {
  SceneReport report;
  for (double tolerance : {1e-3, 1e-6})
    for (int substeps : {1, 2, 4, 8})
      report.points.push_back(
          planted(substeps, tolerance, std::pow(substeps, tolerance < 1e-4 ? -2.0 : -1.0)));
  int seen = 0;
  for (const FittedOrder& order : fitted_orders(report)) {
    if (order.error != "trajectory_rms" || order.axis != "h") continue;
    EXPECT_EQ(order.points, 4);
    EXPECT_NEAR(order.order, order.series.tolerance < 1e-4 ? 2.0 : 1.0, 1e-12);
    ++seen;
  }
  EXPECT_EQ(seen, 2);
}

TEST(SceneOrders, LeaveOutWhatTheReferenceCannotTell) {
  SceneReport report;
  for (int substeps : {1, 2, 4, 8})
    report.points.push_back(planted(substeps, 1e-6, std::pow(substeps, -2.0)));
  const auto points_of_the_trajectory = [&] {
    for (const FittedOrder& order : fitted_orders(report))
      if (order.error == "trajectory_rms" && order.axis == "h") return order.points;
    return 0;
  };
  report.reference.errors.trajectory_rms =
      0.01;  // four times that is between the errors at 4 and at 8 substeps
  EXPECT_EQ(points_of_the_trajectory(), 4 - 1);
  report.reference.errors.trajectory_rms = 1.0;
  EXPECT_EQ(points_of_the_trajectory(), 0);
}

TEST(SceneOrders, OverCellSizeLeaveOutTheReferencesLattice) {
  SceneReport report;
  for (double resolution : {0.25, 0.5, 1.0}) {
    report.points.push_back(planted(4, 1e-6, resolution == 1.0 ? 1e-5 : std::pow(resolution, -2.0)));
    report.points.back().settings.resolution = resolution;
  }
  int seen = 0;
  for (const FittedOrder& order : fitted_orders(report)) {
    if (order.axis != "cell_size") continue;
    EXPECT_NEAR(order.order, 2.0, 1e-12) << order.error;
    EXPECT_EQ(order.points, 2);
    ++seen;
  }
  EXPECT_EQ(seen, 1);
}

TEST(SceneOrders, BudgetTakesTheSmallestErrorThatFits) {
  SceneReport report;
  report.points = {planted(1, 1e-6, 1.0), planted(4, 1e-6, 0.1), planted(16, 1e-6, 0.01),
                   planted(2, 1e-6, 0.001)};
  report.points[3].outcome = Outcome::infeasible;
  ASSERT_NE(fit_budget(report, 8.0), nullptr);
  EXPECT_EQ(fit_budget(report, 8.0)->settings.substeps, 4);  // 95 % of its frames take 6 ms
  EXPECT_EQ(fit_budget(report, 7.0)->settings.substeps, 1);  // less than a fifth above them
  EXPECT_EQ(fit_budget(report, 0.5), nullptr);
}

TEST(SceneOrders, BudgetTellsNoErrorsApartThatAreTheReferencesOwn) {
  SceneReport report;
  report.points = {planted(1, 1e-2, 0.1), planted(1, 1e-2, 0.2), planted(1, 1e-2, 0.3),
                   planted(1, 1e-2, 0.5)};
  const std::array cell_errors{1e-3, 1e-6, 1e-6, 1e-9};
  for (std::size_t i = 0; i < cell_errors.size(); ++i)
    report.points[i].errors.max_cell_volume = cell_errors[i];
  report.points[2].ms_per_step.median *= 0.5;
  EXPECT_EQ(fit_budget(report, 1e3), report.points.data());
  report.reference.errors.trajectory_rms = 0.1;  // four times that is above all but the last
  EXPECT_EQ(fit_budget(report, 1e3), &report.points[2]);
}

}  // namespace
}  // namespace isochor
