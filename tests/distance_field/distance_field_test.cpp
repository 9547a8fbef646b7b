#include "core/distance_field/distance_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "core/common/error.h"
#include "core/parallel/parallel.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using testing::HasSubstr;

const TriangleSoup triangle{{{0, 0, 0}, {3, 0, 0}, {0, 2, 0}}, {{0, 1, 2}}};

Error failure(const TriangleSoup& soup, const DistanceFieldOptions& options) {
  try {
    Progress progress;
    make_distance_field(soup, options, progress);
  } catch (const Error& error) {
    return error;
  }
  return {ErrorCode::internal, "nothing was thrown"};
}

TEST(DistanceGrid, CoversTheBoxWithCubesAndPadding) {
  const Grid grid = distance_grid(bounding_box(triangle), {30, 4});
  EXPECT_DOUBLE_EQ(grid.spacing, 0.1);
  EXPECT_EQ(grid.size, Vec3i(38, 28, 9));
  EXPECT_TRUE((grid.origin + 0.5 * grid.spacing * grid.size.cast<double>()).isApprox(Vec3(1.5, 1.0, 0.0)));
}

TEST(DistanceGrid, RefusesWhatHasNoGrid) {
  EXPECT_EQ(failure(triangle, {15, 4}).code(), ErrorCode::invalid_argument);
  EXPECT_EQ(failure(triangle, {513, 4}).code(), ErrorCode::invalid_argument);
  EXPECT_EQ(failure(triangle, {1000000000, 4}).code(), ErrorCode::invalid_argument);
  EXPECT_EQ(failure(triangle, {64, -1}).code(), ErrorCode::invalid_argument);
  EXPECT_EQ(failure({}, {64, 4}).code(), ErrorCode::empty_result);
  const TriangleSoup point{{{1, 2, 3}}, {{0, 0, 0}}};
  EXPECT_THAT(failure(point, {64, 4}).what(), HasSubstr("in one point"));
  const TriangleSoup tiny{{{0, 0, 0}, {1e-40, 0, 0}, {0, 1e-40, 0}}, {{0, 1, 2}}};
  EXPECT_THAT(failure(tiny, {64, 4}).hint(), HasSubstr("scale it up"));
  const TriangleSoup far{{{1e12, 0, 0}, {1e12 + 1, 0, 0}, {1e12, 1, 0}}, {{0, 1, 2}}};
  EXPECT_THAT(failure(far, {64, 4}).hint(), HasSubstr("move it"));
}

TEST(DistanceField, IsKnownByHandForATriangle) {
  Progress progress;
  const DistanceField field = make_distance_field(triangle, {30, 4}, progress);
  // Above the right-angled corner, beside the long side's start, and in the plane.
  EXPECT_FLOAT_EQ(field.distance[field.grid.index(4, 4, 8)], 0.4F);
  EXPECT_NEAR(field.distance[field.grid.index(0, 4, 4)], 0.35F, 1e-6F);
  EXPECT_NEAR(field.distance[field.grid.index(0, 0, 4)], 0.35F * std::sqrt(2.0F), 1e-6F);
  EXPECT_NEAR(field.distance[field.grid.index(4, 4, 4)], 0.0F, 1e-6F);
}

TEST(DistanceField, ThinnedHoldsTheSameDistancesOnLargerVoxels) {
  Progress progress;
  const DistanceField field = make_distance_field(triangle, {30, 5}, progress);
  const auto middle = [](const Grid& grid) {
    return Vec3(grid.origin + 0.5 * grid.spacing * grid.size.cast<double>());
  };
  for (const int stride : {1, 2, 3}) {
    const DistanceField coarse = thinned(field, stride);
    const Grid& grid = coarse.grid;
    EXPECT_DOUBLE_EQ(grid.spacing, 0.1 * stride);
    EXPECT_LT((middle(grid) - middle(field.grid)).cwiseAbs().maxCoeff(), 0.05 * stride);
    EXPECT_GE(coarse.padding, 4 / stride);
    ASSERT_EQ(std::ssize(coarse.distance), grid.count());
    for (int k = 0; k < grid.size.z(); ++k)
      for (int j = 0; j < grid.size.y(); ++j)
        for (int i = 0; i < grid.size.x(); ++i) {
          const Vec3 at = (grid.center(i, j, k) - field.grid.center(0, 0, 0)) / field.grid.spacing;
          const Vec3i voxel = at.array().round().cast<int>();
          ASSERT_LT((at - voxel.cast<double>()).norm(), 1e-9);
          ASSERT_EQ(coarse.distance[grid.index(i, j, k)],
                    field.distance[field.grid.index(voxel.x(), voxel.y(), voxel.z())]);
        }
  }
}

TEST(DistanceField, NamesTheLargestVoxelsThatFit) {
  DistanceFieldOptions options{400, 4, std::int64_t{30} << 20};
  const Error error = failure(test::torus(1.0, 0.9, 8), options);
  EXPECT_EQ(error.code(), ErrorCode::over_budget);
  int fits = 0;
  ASSERT_EQ(std::sscanf(error.hint().c_str(), "voxels up to %d", &fits), 1) << error.hint();
  EXPECT_GT(fits, 100);
  options.voxels = fits;
  Progress progress;
  EXPECT_NO_THROW(make_distance_field(test::torus(1.0, 0.9, 8), options, progress));
}

TEST(DistanceField, StopsSoonAfterItIsCancelled) {
  for (int threads : {1, 2}) {
    set_thread_count(threads);
    std::atomic<bool> cancel{false};
    int reports = 0;
    Progress progress(
        [&](std::string_view phase, double fraction) {
          EXPECT_EQ(phase, "distance_field");
          EXPECT_LT(fraction, 1.0);
          if (++reports == 3) cancel = true;
        },
        &cancel);
    try {
      make_distance_field(test::torus(1.0, 0.4, 100), {200, 4}, progress);
      ADD_FAILURE() << "not cancelled";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
    }
    EXPECT_EQ(reports, 3);
  }
  set_thread_count(0);
}

TEST(DistanceField, ReportsAllOfItsProgress) {
  double last = -1.0;
  Progress progress([&](std::string_view, double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  make_distance_field(triangle, {150, 4}, progress);
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace isochor
