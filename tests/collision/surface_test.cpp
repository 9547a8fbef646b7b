#include <gtest/gtest.h>

#include <random>

#include "core/collision/box_hash.h"
#include "core/collision/vertex_triangle.h"

namespace isochor {
namespace {

Box random_box(std::mt19937& random, double largest) {
  std::uniform_real_distribution<double> at(-1.0, 1.0), size(0.0, largest);
  Box box;
  box.min = Vec3(at(random), at(random), at(random));
  box.max = box.min + Vec3(size(random), size(random), size(random));
  return box;
}

TEST(BoxHash, FindsWhatComparingAllPairsFinds) {
  std::mt19937 random(1);
  for (const double largest : {0.0, 0.1, 1.5}) {
    std::vector<Box> boxes;
    for (int i = 0; i < 300; ++i) boxes.push_back(random_box(random, i % 50 == 0 ? 2.0 : largest));
    BoxHash hash;
    hash.build(boxes);
    std::size_t found = 0;
    for (int query = 0; query < 200; ++query) {
      const Box box = random_box(random, 0.3);
      std::vector<std::int32_t> expected;
      for (std::size_t i = 0; i < boxes.size(); ++i)
        if (overlaps(box, boxes[i])) expected.push_back(static_cast<std::int32_t>(i));
      const auto got = hash.find(box);
      EXPECT_EQ(std::vector<std::int32_t>(got.begin(), got.end()), expected);
      found += expected.size();
    }
    EXPECT_GT(found, 0U);
  }
}

TEST(BoxHash, HoldsNothingOrOnePoint) {
  BoxHash hash;
  hash.build({});
  Box point;
  point.extend(Vec3(1.0, 2.0, 3.0));
  EXPECT_TRUE(hash.find(point).empty());
  hash.build(std::array{point});
  EXPECT_EQ(hash.find(point).size(), 1U);
  EXPECT_TRUE(hash.find(grown(Box{Vec3::Zero(), Vec3::Zero()}, 0.5)).empty());
}

const TrianglePoints flat{Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0), Vec3(1.0, 0.0, 0.0)};  // seen from above

VertexSweep sweep(const Vec3& from, const Vec3& to, const Vec3& triangle_moves = Vec3::Zero()) {
  VertexSweep s{from, to, flat, flat};
  for (Vec3& corner : s.end) corner += triangle_moves;
  return s;
}

TEST(VertexSweep, GoesThroughFromTheFrontOnly) {
  EXPECT_NEAR(sweep({0.2, 1.0, 0.2}, {0.2, -3.0, 0.2}).entry(0.1).value(), 0.25, 1e-9);
  EXPECT_FALSE(sweep({0.2, -1.0, 0.2}, {0.2, 3.0, 0.2}).entry(0.1));
  EXPECT_FALSE(sweep({0.2, 1.0, 0.2}, {0.2, 0.1, 0.2}).entry(0.1));
  EXPECT_FALSE(sweep({0.7, 1.0, 0.7}, {0.7, -3.0, 0.7}).entry(0.1));
  // Past the edge at the end, through the triangle on the way.
  EXPECT_TRUE(sweep({0.2, 0.1, 0.2}, {9.0, -9.0, 9.0}).entry(0.1));
}

TEST(VertexSweep, CountsWhatStartsALittleBehindAsFromTheFront) {
  EXPECT_DOUBLE_EQ(sweep({0.2, -0.05, 0.2}, {0.2, -0.2, 0.2}).entry(0.1).value(), 0.0);
  EXPECT_FALSE(sweep({0.2, -0.15, 0.2}, {0.2, -0.2, 0.2}).entry(0.1));
}

TEST(VertexSweep, SeesTheTriangleMove) {
  EXPECT_NEAR(sweep({0.2, 1.0, 0.2}, {0.2, 1.0, 0.2}, {0.0, 4.0, 0.0}).entry(0.1).value(), 0.25, 1e-9);
  EXPECT_FALSE(sweep({0.2, 1.0, 0.2}, {0.2, -3.0, 0.2}, {0.0, -5.0, 0.0}).entry(0.1));
}

TEST(WeightsAlong, AreThoseOfTheFootAndSumToOne) {
  const Vec3 direction = Vec3(0.3, 1.0, -0.2);
  const Vec3 foot = 0.5 * flat[0] + 0.2 * flat[1] + 0.3 * flat[2];
  const auto weights = weights_along(foot + 2.0 * direction, direction, flat);
  ASSERT_TRUE(weights);
  EXPECT_LT((*weights - Vec3(0.5, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_FALSE(weights_along(Vec3(0.0, 1.0, 0.0), Vec3::UnitX(), flat));
}

}  // namespace
}  // namespace isochor
