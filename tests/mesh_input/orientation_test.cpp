#include "core/mesh_input/orientation.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/shapes.h"

namespace isochor {
namespace {

TriangleSoup cube(const Vec3& center, double half) {
  return test::box(center - Vec3::Constant(half), center + Vec3::Constant(half));
}

TriangleSoup turned(TriangleSoup soup) {
  for (Triangle& t : soup.triangles) std::swap(t[0], t[1]);
  return soup;
}

TriangleSoup joined(const std::vector<TriangleSoup>& parts) {
  TriangleSoup soup;
  for (const TriangleSoup& part : parts) test::append(soup, part);
  return soup;
}

/// What the parts' volumes sum to once they face outward, and once the whole soup was turned before.
void expect_outward(const TriangleSoup& soup, double volume) {
  EXPECT_NEAR(signed_volume(facing_outward(soup)), volume, 1e-12);
  EXPECT_NEAR(signed_volume(facing_outward(turned(soup))), volume, 1e-12);
}

const Vec3 here = Vec3::Zero(), beside(5, 0, 0);

TEST(FacingOutward, TurnsPartsThatFaceInward) {
  expect_outward(joined({cube(here, 1), turned(cube(beside, 1))}), 16.0);
  expect_outward(joined({cube(here, 1), turned(cube({1.2, 0.7, 0.3}, 1))}), 16.0);
}

TEST(FacingOutward, KeepsCavitiesWhicheverWayTheSoupFaces) {
  const TriangleSoup hollow = joined({cube(here, 1), turned(cube(here, 0.5))});
  expect_outward(joined({hollow, cube(beside, 2)}), 8.0 - 1.0 + 64.0);
  expect_outward(joined({turned(hollow), cube(beside, 2)}), 8.0 - 1.0 + 64.0);
  const TriangleSoup rod = test::box({-2, -0.1, -0.1}, {2, 0.1, 0.1});
  expect_outward(joined({hollow, rod}), 8.0 - 1.0 + 0.16);
  expect_outward(joined({hollow, cube(here, 0.2)}), 8.0 - 1.0 + 0.064);  // a kernel in the cavity
}

TEST(FacingOutward, TurnsWhatLiesWithinAnotherWithIt) {
  const TriangleSoup nested = joined({cube(here, 1), cube(here, 0.5)});
  expect_outward(joined({turned(nested), cube(beside, 2)}), 8.0 + 1.0 + 64.0);
}

TEST(FacingAlike, TurnsTheFewer) {
  TriangleSoup soup = joined({test::sphere(1.0, 1.0, 24), cube(beside, 1)});
  const double volume = signed_volume(soup);
  std::mt19937 random(1);
  for (Triangle& t : soup.triangles)
    if (random() % 3 == 0) std::swap(t[0], t[1]);
  ASSERT_LT(std::abs(signed_volume(soup)), 0.6 * std::abs(volume));
  const auto alike = facing_alike(soup);
  ASSERT_TRUE(alike);
  EXPECT_NEAR(signed_volume(*alike), volume, 1e-12);
}

TEST(FacingAlike, KnowsWhatHasNoTwoSides) {
  EXPECT_FALSE(facing_alike(test::sheet(1.0)));
  EXPECT_FALSE(facing_alike(joined({cube(here, 1), cube({2, 0, 0}, 1)})));  // they share a face
  // The projective plane on six points.
  TriangleSoup plane{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0.3, 1, 1}},
                     {{0, 1, 4},
                      {0, 1, 5},
                      {0, 2, 3},
                      {0, 2, 5},
                      {0, 3, 4},
                      {1, 2, 3},
                      {1, 2, 4},
                      {1, 3, 5},
                      {2, 4, 5},
                      {3, 4, 5}}};
  EXPECT_FALSE(facing_alike(plane));
}

}  // namespace
}  // namespace isochor
