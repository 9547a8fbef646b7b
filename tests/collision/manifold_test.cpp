#include "core/collision/manifold.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/print_shape_type.h"

namespace isochor {
namespace {

std::unique_ptr<CollisionShape> make(ShapeType type) {
  switch (type) {
    case ShapeType::plane:
      return make_plane({0.2, 1.0, -0.1}, 0.1);
    case ShapeType::sphere:
      return make_sphere(0.4);
    case ShapeType::box:
      return make_box({0.5, 0.2, 0.35});
    default:
      return make_capsule(0.25, 0.45);
  }
}

class Pair : public testing::TestWithParam<std::tuple<ShapeType, ShapeType>> {
 protected:
  Vec3 sample(double reach) { return reach * Vec3(uniform(random), uniform(random), uniform(random)); }
  Pose random_pose(double reach) { return {sample(reach), rotation_exp(sample(2.0))}; }
  /// Least distance to b over points within a: negative when they overlap.
  double sampled_distance(const Pose& pose_a, const Pose& pose_b) {
    double least = 1e300;
    for (int i = 0; i < 4000; ++i) {
      Vec3 p = sample(1.0);
      const SurfaceQuery q = a->query(p);
      if (q.distance > 0.0) p -= q.distance * q.normal;
      least = std::min(least, b->query(pose_b.to_local(pose_a.to_world(p))).distance);
    }
    return least;
  }

  std::unique_ptr<CollisionShape> a = make(std::get<0>(GetParam())), b = make(std::get<1>(GetParam()));
  std::mt19937 random{11};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
};

TEST_P(Pair, SeparationIsNegativeExactlyWhenTheShapesOverlap) {
  int overlaps = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose pa = random_pose(0.9), pb = random_pose(0.3);
    Manifold manifold;
    const double separation = collide({*a, pa}, {*b, pb}, 10.0, manifold);
    const double sampled = sampled_distance(pa, pb);
    overlaps += sampled < 0.0;
    EXPECT_LE(separation, sampled + 1e-12);
    EXPECT_TRUE(sampled < 0.05 || separation > 0.0);
  }
  EXPECT_GT(overlaps, 5);
}

TEST_P(Pair, TheDeepestPointSaysHowToPart) {
  for (int i = 0; i < 300; ++i) {
    Pose pa = random_pose(0.9);
    const Pose pb = random_pose(0.3);
    Manifold manifold;
    const double separation = collide({*a, pa}, {*b, pb}, 10.0, manifold);
    if (manifold.points().empty()) {
      EXPECT_GT(separation, 0.0);  // boxes beside each other
      continue;
    }
    ManifoldPoint deepest = manifold.points()[0];
    for (const ManifoldPoint& p : manifold.points()) {
      EXPECT_NEAR(p.normal.norm(), 1.0, 1e-12);
      EXPECT_GE(p.gap(), separation - 3e-6);
      if (p.gap() < deepest.gap()) deepest = p;
    }
    // Deeper than a capsule's radius its axis is inside, and one point does not tell the shortest way out.
    if (separation > 0.0 || separation < -0.25) continue;
    // Moved out by the depth along the normal they touch, no more and no less.
    EXPECT_NEAR(deepest.gap(), separation, 3e-6);
    pa.position -= separation * deepest.normal;
    Manifold parted;
    EXPECT_NEAR(collide({*a, pa}, {*b, pb}, 1.0, parted), 0.0, 3e-6);
  }
}

TEST_P(Pair, ExchangingTheShapesMirrorsTheContact) {
  for (int i = 0; i < 50; ++i) {
    const Pose pa = random_pose(0.9), pb = random_pose(0.3);
    Manifold there, back;
    EXPECT_NEAR(collide({*a, pa}, {*b, pb}, 0.2, there), collide({*b, pb}, {*a, pa}, 0.2, back), 1e-12);
    ASSERT_EQ(there.points().size(), back.points().size());
    double least_there = 1e300, least_back = 1e300;
    for (const ManifoldPoint& p : there.points()) least_there = std::min(least_there, p.gap());
    for (const ManifoldPoint& p : back.points()) least_back = std::min(least_back, p.gap());
    EXPECT_NEAR(least_there, least_back, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Pair,
                         testing::Combine(testing::Values(ShapeType::sphere, ShapeType::box,
                                                          ShapeType::capsule),
                                          testing::Values(ShapeType::plane, ShapeType::sphere, ShapeType::box,
                                                          ShapeType::capsule)));

TEST(Manifold, ABoxOnABoxStandsOnFourCorners) {
  const auto box = make_box({0.5, 0.5, 0.5});
  for (const double nudge : {-1e-12, 0.0, 1e-12}) {
    const Pose above{{nudge, 1.0 - 1e-6, -nudge}, rotation_exp({0.0, nudge, 0.0})}, below;
    Manifold manifold;
    EXPECT_NEAR(collide({*box, above}, {*box, below}, 1e-3, manifold), -1e-6, 1e-11);
    ASSERT_EQ(manifold.points().size(), 4u);
    for (const ManifoldPoint& p : manifold.points()) {
      EXPECT_NEAR(p.gap(), -1e-6, 1e-11);
      EXPECT_LT((p.normal - Vec3::UnitY()).norm(), 1e-11);
      EXPECT_NEAR(std::abs(p.point().x()), 0.5, 1e-11);
      EXPECT_NEAR(std::abs(p.point().z()), 0.5, 1e-11);
    }
  }
}

TEST(Manifold, CrossedEdgesTouchWhereTheyCross) {
  const auto box = make_box({0.5, 0.5, 0.5});
  const double quarter = std::atan(1.0), half_diagonal = std::sqrt(0.5);
  const Pose above{{0.1, 2.0 * half_diagonal - 0.01, -0.05}, rotation_exp({quarter, 0.0, 0.0})};
  const Pose below{Vec3::Zero(), rotation_exp({0.0, 0.0, quarter})};
  Manifold manifold;
  EXPECT_NEAR(collide({*box, above}, {*box, below}, 1e-3, manifold), -0.01, 1e-9);
  ASSERT_EQ(manifold.points().size(), 1u);
  EXPECT_LT((manifold.points()[0].normal - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_NEAR(manifold.points()[0].point().x(), 0.0, 1e-12);
  EXPECT_NEAR(manifold.points()[0].point().z(), -0.05, 1e-12);
}

TEST(Manifold, ACapsuleLyingOnABoxTouchesAtBothEnds) {
  const auto capsule = make_capsule(0.1, 0.3), box = make_box({1.0, 0.5, 1.0});
  const Pose lying{{0.2, 0.6, 0.0}, rotation_exp({0.0, 0.0, 2.0 * std::atan(1.0)})};
  Manifold manifold;
  collide({*capsule, lying}, {*box, {}}, 1e-6, manifold);
  double least = 1e300, most = -1e300;
  for (const ManifoldPoint& p : manifold.points()) {
    EXPECT_NEAR(p.gap(), 0.0, 1e-12);
    least = std::min(least, p.point().x()), most = std::max(most, p.point().x());
  }
  EXPECT_NEAR(least, -0.1, 1e-12);
  EXPECT_NEAR(most, 0.5, 1e-12);
}

TEST(Manifold, ReducingKeepsTheDeepestAndTheSpread) {
  Manifold manifold;
  for (int i = 0; i < 200; ++i) {
    ManifoldPoint p;
    p.core_b = Vec3(i % 20, 0.0, i / 20);
    p.core_a = p.core_b + (i == 77 ? -0.5 : 0.1) * Vec3::UnitY();
    manifold.add(p);
  }
  EXPECT_LE(manifold.points().size(), 64u);
  manifold.reduce(4);
  ASSERT_EQ(manifold.points().size(), 4u);
  EXPECT_EQ(manifold.points()[0].gap(), -0.5);
}

}  // namespace
}  // namespace isochor
