#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include "core/distance_field/closest_point.h"
#include "core/distance_field/fill.h"
#include "core/parallel/parallel.h"
#include "tests/distance_field/soups.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

double brute_force(const TriangleSoup& soup, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : soup.triangles) {
    const Vec3 closest =
        closest_point_on_triangle(x, soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]);
    least = std::min(least, (closest - x).norm());
  }
  return least;
}

/// A hundred-thousandth of a voxel, or half a unit in the last place of the float where that is more.
double allowed_error(double distance, double spacing) {
  const auto rounded = static_cast<float>(distance);
  const double ulp = std::nextafter(rounded, std::numeric_limits<float>::infinity()) - rounded;
  return std::max(1e-5 * spacing, 0.5 * ulp);
}

DistanceField fill(const TriangleSoup& soup, const BlockKernel& kernel, const DistanceFieldOptions& options) {
  DistanceField field;
  field.grid = distance_grid(bounding_box(soup), options);
  field.distance.resize(field.grid.count(), -1.0F);
  Progress progress;
  fill_distances(soup, kernel, field, progress);
  return field;
}

std::vector<NamedSoup>& soups() {
  static std::vector<NamedSoup> all = hard_soups();
  return all;
}

using Case = std::tuple<std::size_t, std::size_t>;  // kernel, soup

class Exactness : public testing::TestWithParam<Case> {};

TEST_P(Exactness, HoldsForEveryVoxel) {
  const BlockKernel& kernel = block_kernels()[std::get<0>(GetParam())];
  const TriangleSoup& soup = soups()[std::get<1>(GetParam())].soup;
  const DistanceField field = fill(soup, kernel, {21, 5});
  const Grid& grid = field.grid;
  int wrong = 0;
  double worst = 0.0, largest = 0.0;
  for (int k = 0; k < grid.size.z(); ++k)
    for (int j = 0; j < grid.size.y(); ++j)
      for (int i = 0; i < grid.size.x(); ++i) {
        const double truth = brute_force(soup, grid.center(i, j, k));
        const double error = std::abs(field.distance[grid.index(i, j, k)] - truth);
        wrong += error <= allowed_error(truth, grid.spacing) ? 0 : 1;
        worst = std::max(worst, error / grid.spacing);
        largest = std::max(largest, truth);
      }
  EXPECT_EQ(wrong, 0) << "worst error " << worst << " voxels";
  EXPECT_NEAR(field.max_distance, largest, allowed_error(largest, grid.spacing));
}

std::string case_name(const testing::TestParamInfo<Case>& test) {
  std::string name =
      soups()[std::get<1>(test.param)].name + "_" + block_kernels()[std::get<0>(test.param)].name;
  std::replace(name.begin(), name.end(), '-', 'm');
  return name;
}

INSTANTIATE_TEST_SUITE_P(KernelsAndSoups, Exactness,
                         testing::Combine(testing::Range<std::size_t>(0, block_kernels().size()),
                                          testing::Range<std::size_t>(0, soups().size())),
                         case_name);

class LargeGrid : public testing::TestWithParam<std::size_t> {};

// Far from the surface, on the medial axis and with more features in a block than fit at once.
TEST_P(LargeGrid, AgreesAtRandomVoxels) {
  const TriangleSoup soup = test::torus(1.0, 0.4, 160);
  const DistanceField field = fill(soup, block_kernels()[GetParam()], {110, 20});
  std::mt19937 random(7);
  for (int sample = 0; sample < 3000; ++sample) {
    const auto at = [&](int axis) {
      return std::uniform_int_distribution<int>(0, field.grid.size[axis] - 1)(random);
    };
    const int i = at(0), j = at(1), k = at(2);
    const double truth = brute_force(soup, field.grid.center(i, j, k));
    ASSERT_NEAR(field.distance[field.grid.index(i, j, k)], truth, allowed_error(truth, field.grid.spacing))
        << i << " " << j << " " << k;
  }
}

// All of the sphere is about as far from its centre: every feature is a candidate there.
TEST_P(LargeGrid, AgreesAroundTheCenterOfASphere) {
  const TriangleSoup soup = test::sphere(1.0, 1.0, 200);
  const DistanceField field = fill(soup, block_kernels()[GetParam()], {64, 4});
  const Vec3i middle = field.grid.size / 2;
  for (int i = -5; i < 5; ++i)
    for (int j = -5; j < 5; ++j) {
      const Vec3i at = middle + Vec3i(i, j, (i + 2 * j) % 5);
      const double truth = brute_force(soup, field.grid.center(at.x(), at.y(), at.z()));
      ASSERT_NEAR(field.distance[field.grid.index(at.x(), at.y(), at.z())], truth,
                  allowed_error(truth, field.grid.spacing));
    }
}

std::string kernel_name(const testing::TestParamInfo<std::size_t>& test) {
  return block_kernels()[test.param].name;
}

INSTANTIATE_TEST_SUITE_P(Kernels, LargeGrid, testing::Range<std::size_t>(0, block_kernels().size()),
                         kernel_name);

TEST(Threads, GiveTheSameBits) {
  const TriangleSoup soup = test::torus(1.0, 0.4, 60);
  for (const BlockKernel& kernel : block_kernels()) {
    set_thread_count(1);
    const DistanceField one = fill(soup, kernel, {80, 8});
    for (int threads : {2, 3}) {
      set_thread_count(threads);
      const DistanceField many = fill(soup, kernel, {80, 8});
      EXPECT_EQ(many.distance, one.distance) << kernel.name << " " << threads;
      EXPECT_EQ(many.max_distance, one.max_distance);
    }
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace isochor
