#include "core/report/meshing_report.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace isochor {
namespace {

MeshingPoint made_in(double ms, double boundary_to_input, double input_to_boundary) {
  MeshingPoint point;
  point.ms = {0.7 * ms, 0.5 * ms, 0.8 * ms};  // four fifths at most
  point.quality.boundary_to_input = boundary_to_input;
  point.quality.input_to_boundary = input_to_boundary;
  return point;
}

MeshingPoint only_point(TriangleSoup soup, int cells) {
  MeshingReportOptions options;
  options.base.voxels = 48, options.base.lattice.cells = cells;
  options.repeats = 1;
  Progress progress;
  const MeshingReport report =
      report_meshing(std::make_shared<const TriangleSoup>(std::move(soup)), options, progress);
  EXPECT_EQ(report.points.size(), 1U);
  return report.points.at(0);
}

TEST(MeshingReport, AModelThatMissesAPartIsNotTheBestWithinABudget) {
  MeshingReport report;
  report.points = {made_in(10, 0.1, 3.0), made_in(20, 0.2, 0.3), made_in(50, 0.01, 0.01)};
  EXPECT_EQ(fit_budget(report, 30.0), &report.points[1]);
  EXPECT_EQ(fit_budget(report, 10.0), report.points.data());
  EXPECT_EQ(fit_budget(report, 5.0), nullptr);
  report.points[1].incomplete = "it covers a tenth of its input";
  EXPECT_EQ(fit_budget(report, 30.0), report.points.data());
}

TEST(MeshingReport, AnIncompleteModelIsSaidToBeOne) {
  TriangleSoup sheet;
  sheet.positions = {{0, 0, 0}, {1, 0.3, 0}, {1, 0.5, 1}, {0, 0.2, 1}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const MeshingPoint point = only_point(std::move(sheet), 6);
  EXPECT_FALSE(point.problem.empty() && point.incomplete.empty());
}

TEST(MeshingReport, TheVolumeErrorOfAShellIsThatOfItsWall) {
  TriangleSoup shell = test::sphere(0.5, 1.0, 48);
  test::append(shell, test::sphere(0.3, 1.0, 48));  // of the same sense: the signed volume adds the cavity
  const MeshingPoint point = only_point(std::move(shell), 16);
  EXPECT_LT(std::abs(point.volume_error.value()), 0.06);
  EXPECT_EQ(point.distance(), std::max(point.quality.boundary_to_input, point.quality.input_to_boundary));
}

TEST(MeshingReport, ResumedOverNarrowerAxesKeepsEveryPoint) {
  const auto torus = std::make_shared<const TriangleSoup>(test::torus(0.35, 0.15));
  MeshingReportOptions options;
  options.base.voxels = 32, options.base.lattice.cells = 8;
  options.axes.cells = {4, 8, 64};
  options.repeats = 1;
  Progress progress;
  const MeshingReport whole = report_meshing(torus, options, progress);
  ASSERT_EQ(whole.points.size(), 3U);
  EXPECT_FALSE(
      whole.points[2].problem.empty());  // more cells than half the voxels: neither time nor distance
  EXPECT_TRUE(std::isnan(whole.points[2].ms.median) && std::isnan(whole.points[2].distance()));

  options.done = whole.points;
  options.axes.cells = {6, 8};
  EXPECT_EQ(report_meshing(torus, options, progress).points.size(), 4U);
  options.base.smoothing.iterations += 1, options.axes.smoothing_iterations = {0};  // an axis
  EXPECT_EQ(report_meshing(torus, options, progress).points.size(), 5U);
  options.base.lattice.density *= 0.5;  // none
  EXPECT_THROW(report_meshing(torus, options, progress), Error);
}

TEST(MeshingReport, CountsTheTetsThatARunGives) {
  AuthoringPipeline pipeline(std::make_shared<const TriangleSoup>(test::torus(0.35, 0.15)));
  Progress progress;
  for (const int cells : {2, 8, 14}) {
    MeshingOptions options;
    options.voxels = 48, options.lattice.cells = cells;
    const std::int64_t tets = pipeline.count_tets(options, progress);
    if (tets > 0)
      EXPECT_EQ(tets, static_cast<std::int64_t>(pipeline.run(options, progress)->mesh().tets.size()));
    else
      EXPECT_THROW(pipeline.run(options, progress), Error);
  }
}

}  // namespace
}  // namespace isochor
