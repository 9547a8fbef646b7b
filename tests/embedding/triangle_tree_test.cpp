#include "core/embedding/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/distance_field/closest_point.h"

namespace isochor {
namespace {

/// Triangles whose third corner is `height` away from their longest edge, some of them mere edges or points.
TriangleSoup triangles_of_height(double height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto point = [&] { return Vec3(place(random), place(random), place(random)); };
  TriangleSoup soup;
  for (int t = 0; t < 60; ++t) {
    const Vec3 a = point(), b = t % 7 == 0 ? a : point(), along = a + 0.5 * (1.0 + place(random)) * (b - a);
    for (const Vec3& corner : {a, b, Vec3(along + height * point())}) soup.positions.push_back(corner);
    const std::int32_t first = 3 * t;
    const std::int32_t turn = t % 3;
    soup.triangles.push_back({first + turn, first + (turn + 1) % 3, first + (turn + 2) % 3});
  }
  return soup;
}

class TriangleTreeNearest : public testing::TestWithParam<double> {};

TEST_P(TriangleTreeNearest, IsThatOfBruteForce) {
  const TriangleSoup soup = triangles_of_height(GetParam(), 5);
  const TriangleTree tree(soup.positions, soup.triangles);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  std::int32_t hint = -1;
  for (int n = 0; n < 500; ++n) {
    const Vec3 p(place(random), place(random), place(random));
    const auto distance = [&](const Triangle& t) {
      const Vec3 &a = soup.positions[t[0]], &b = soup.positions[t[1]], &c = soup.positions[t[2]];
      return (closest_point_on_triangle(p, a, b, c) - p).norm();
    };
    double least = 1e300;
    for (const Triangle& t : soup.triangles) least = std::min(least, distance(t));
    const TriangleTree::Nearest found = tree.nearest(p, hint);
    EXPECT_NEAR(std::sqrt(found.squared_distance), least, 4e-14);
    EXPECT_NEAR(distance(soup.triangles[found.triangle]), least, 4e-14);
    hint = found.triangle;
  }
}

// From fat triangles over slivers to such without area.
INSTANTIATE_TEST_SUITE_P(Heights, TriangleTreeNearest, testing::Values(1.0, 1e-3, 1e-7, 1e-11, 1e-15, 0.0));

TEST(TriangleTree, OfNothingFindsNothing) {
  EXPECT_EQ(TriangleTree({}, {}).nearest(Vec3::Zero()).triangle, -1);
}

}  // namespace
}  // namespace isochor
