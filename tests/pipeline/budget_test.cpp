#include <gtest/gtest.h>
#include <sys/resource.h>

#include <numbers>

#include "core/pipeline/pipeline.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

TEST(Budget, TheEstimateBoundsWhatIsMade) {
  const auto soup = std::make_shared<const TriangleSoup>(test::box(Vec3::Zero(), Vec3(1, 2, 3)));
  MeshingOptions options;
  options.voxels = 60, options.lattice.cells = 20;
  Progress progress;
  const auto model = AuthoringPipeline(soup).run(options, progress);
  const Estimate e = estimate(soup_size(*soup), options);
  EXPECT_EQ(e.voxels, model->field->grid.count());
  EXPECT_GE(e.max_cells, static_cast<std::int64_t>(model->mesh().cells.size()));
  EXPECT_EQ(e.max_tets, 5 * e.max_cells);
  EXPECT_GT(e.seconds, 0.0);
}

TEST(SoupSize, KnowsVolumesByParityWhateverTheOrientation) {
  constexpr double ball = std::numbers::pi / 6.0;
  TriangleSoup soup = test::sphere(0.5, 1.0, 32);
  EXPECT_NEAR(soup_size(soup).volume / ball, 1.0, 0.02);
  for (std::size_t t = 0; t < soup.triangles.size(); t += 2)
    std::swap(soup.triangles[t][0], soup.triangles[t][1]);
  EXPECT_NEAR(soup_size(soup).volume / ball, 1.0, 0.02);
  test::append(soup, test::sphere(0.4, 1.0, 32));  // a shell
  EXPECT_NEAR(soup_size(soup).volume / (ball * (1.0 - 0.512)), 1.0, 0.03);
  EXPECT_NEAR(soup_size(test::box({1e6, 0, 0}, {1e6 + 1, 2, 3})).volume, 6.0, 0.1);
  EXPECT_EQ(soup_size(TriangleSoup{{{1, 2, 3}}, {{0, 0, 0}}}).volume, 0.0);
}

long peak_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Each would cross thousands of columns: gigabytes, from a file of a few megabytes.
TEST(SoupSize, TakesFewerColumnsOfLargeTrianglesOverEachOther) {
  TriangleSoup soup = test::box(Vec3::Zero(), Vec3(2, 3, 4));
  const std::vector<Triangle> once = soup.triangles;
  for (int copy = 1; copy < 50'001; ++copy)
    soup.triangles.insert(soup.triangles.end(), once.begin(), once.end());
  const long before = peak_kib();
  EXPECT_NEAR(soup_size(soup).volume, 24.0, 3.0);
  EXPECT_LT(peak_kib() - before, 1 << 20);
}

TEST(Budget, NamesTheLargestCellsThatFit) {
  const TriangleSoup soup = test::box(Vec3::Zero(), Vec3::Ones());
  MeshingOptions options;
  options.voxels = 256, options.lattice.cells = 128;
  MeshingOptions smaller = options;
  smaller.lattice.cells = 40;
  const std::int64_t limit = estimate(soup_size(soup), smaller).bytes;
  try {
    check_budget(soup_size(soup), options, limit);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::over_budget);
    EXPECT_EQ(error.details().at(0).pointer, "/cells");
    EXPECT_EQ(error.details().at(0).max, 40.0);
  }
  EXPECT_NO_THROW(check_budget(soup_size(soup), smaller, limit));
}

TEST(Budget, NamesTheLargestVoxelsWhenNoNumberOfCellsFits) {
  const TriangleSoup soup = test::box(Vec3::Zero(), Vec3::Ones());
  MeshingOptions options;
  options.voxels = 512;
  MeshingOptions smaller = options;
  smaller.voxels = 100;
  try {
    check_budget(soup_size(soup), options, estimate(soup_size(soup), smaller).bytes);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.details().at(0).pointer, "/voxels");
    EXPECT_EQ(error.details().at(0).max, 100.0);
  }
}

TEST(Budget, APreviewKeepsDistancesAtFewerVoxels) {
  MeshingOptions options;
  options.pseudo_volume.p_in_voxels = 4.0, options.pseudo_volume.p_subs_voxels = 6.0;
  const MeshingOptions preview = preview_options(options);
  EXPECT_EQ(preview.voxels, 64);
  EXPECT_DOUBLE_EQ(preview.pseudo_volume.p_in_voxels, 2.0);
  EXPECT_DOUBLE_EQ(preview.pseudo_volume.p_subs_voxels, 3.0);
  EXPECT_EQ(preview.lattice.cells, 24);
  options.voxels = 256, options.lattice.cells = 64;
  EXPECT_EQ(preview_options(options).lattice.cells, 32);
  EXPECT_DOUBLE_EQ(preview_options(options).pseudo_volume.p_in_voxels, 1.0);
  options.voxels = 40;
  EXPECT_EQ(preview_options(options).voxels, 40);
  EXPECT_EQ(preview_options(options, 12).voxels, 24);
  EXPECT_EQ(preview_options(options, 12).lattice.cells, 12);
}

TEST(Budget, APreviewStepsOverVoxelsThatNeitherCellsNorThresholdsNeed) {
  const auto stride = [](int voxels, int cells, double p_in, int most_cells = most_preview_cells,
                         bool encloses = false) {
    MeshingOptions options;
    options.voxels = voxels, options.lattice.cells = cells;
    options.pseudo_volume.p_in_voxels = p_in;
    return preview_stride(options, most_cells, encloses);
  };
  EXPECT_EQ(stride(128, 24, 4.0), 2);
  EXPECT_EQ(stride(128, 12, 4.0, 16), 4);
  EXPECT_EQ(stride(128, 24, 1.0), 1);
  EXPECT_EQ(stride(128, 24, 1.0, 32, true), 2);
  EXPECT_EQ(stride(128, 48, 4.0), 1);
  EXPECT_EQ(stride(512, 48, 8.0), 5);
  EXPECT_EQ(stride(512, 48, 2.0), 2);
  EXPECT_EQ(stride(40, 10, 4.0), 1);
}

}  // namespace
}  // namespace isochor
