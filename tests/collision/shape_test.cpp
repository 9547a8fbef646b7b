#include "core/collision/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/common/error.h"

namespace isochor {
namespace {

struct Case {
  const char* name;
  std::unique_ptr<CollisionShape> (*make)();
  double reach;  ///< samples are drawn from [−reach, reach]³
};
void PrintTo(const Case& shape, std::ostream* out) {
  *out << shape.name;
}

const Case cases[] = {
    {"plane",
     [] {
       return make_plane({1.0, 2.0, -0.5}, 0.3);
     },
     2.0},
    {"sphere", [] { return make_sphere(0.7); }, 1.5},
    {"box",
     [] {
       return make_box({0.5, 0.05, 1.1});
     },
     1.5},
    {"capsule", [] { return make_capsule(0.3, 0.6); }, 1.5},
};

class Shape : public testing::TestWithParam<Case> {
 protected:
  Vec3 sample() { return {uniform(random), uniform(random), uniform(random)}; }

  std::unique_ptr<CollisionShape> shape = GetParam().make();
  std::mt19937 random{7};
  std::uniform_real_distribution<double> uniform{-GetParam().reach, GetParam().reach};
};

TEST_P(Shape, ClosestPointLiesOnTheSurfaceAndNoneIsCloser) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = sample();
    const SurfaceQuery q = shape->query(p);
    EXPECT_NEAR(q.normal.norm(), 1.0, 1e-14);
    EXPECT_NEAR(shape->query(p - q.distance * q.normal).distance, 0.0, 1e-14);
    // A ball of radius |distance| around p stays on p's side of the surface.
    for (int j = 0; j < 50; ++j) {
      const Vec3 inside_ball = p + 0.999999 * std::abs(q.distance) * sample().normalized();
      EXPECT_GT(shape->query(inside_ball).distance * q.distance, 0.0);
    }
  }
}

TEST_P(Shape, NormalIsTheGradientOfTheDistance) {
  const double step = 1e-6;
  int smooth = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = sample();
    Vec3 gradient;
    double kink = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double ahead = shape->query(p + step * Vec3::Unit(axis)).distance;
      const double behind = shape->query(p - step * Vec3::Unit(axis)).distance;
      gradient[axis] = (ahead - behind) / (2.0 * step);
      kink = std::max(kink, std::abs(ahead + behind - 2.0 * shape->query(p).distance));
    }
    if (kink > 0.01 * step) continue;  // across a medial plane
    ++smooth;
    EXPECT_NEAR(gradient.norm(), 1.0, 1e-6);
    EXPECT_LT((gradient - shape->query(p).normal).norm(), 1e-5);
  }
  EXPECT_GT(smooth, 450);
}

TEST_P(Shape, DistanceIsContinuousAndNormalsAreUnitAtEveryBorder) {
  const double borders[] = {-1.1, -0.6, -0.5, -0.3, -0.05, 0.0, 0.05, 0.3, 0.5, 0.6, 0.7, 1.1};
  for (const double x : borders)
    for (const double y : borders)
      for (const double z : borders)
        for (const double nudge : {-1e-12, 0.0, 1e-12}) {
          const Vec3 p(x + nudge, y - nudge, z + nudge);
          const SurfaceQuery at = shape->query({x, y, z}), near = shape->query(p);
          EXPECT_NEAR(near.normal.norm(), 1.0, 1e-14);
          EXPECT_NEAR(at.distance, near.distance, 2e-12);
          EXPECT_EQ(near.normal, shape->query(p).normal);
        }
}

TEST_P(Shape, SweepStopsAtTheFirstSurfacePoint) {
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 from = sample(), to = sample();
    const auto hit = shape->sweep(from, to);
    double least = 1e300;  // of the distance up to the hit, or along all of the segment
    const double until = hit ? hit->fraction : 1.0;
    for (int j = 0; j <= 100; ++j)
      least = std::min(least, shape->query(from + (until * j / 100.0) * (to - from)).distance);
    if (shape->query(from).distance < 0.0) {
      EXPECT_FALSE(hit);
      continue;
    }
    EXPECT_GT(least, -1e-12);
    if (!hit) continue;
    ++hits;
    const Vec3 at = from + hit->fraction * (to - from);
    EXPECT_NEAR(shape->query(at).distance, 0.0, 1e-12);
    EXPECT_LE(hit->normal.dot(to - from), 0.0);
    EXPECT_LT(shape->query(from + (hit->fraction + 1e-9) * (to - from)).distance, 0.0);
  }
  EXPECT_GT(hits, 100);
}

TEST_P(Shape, SweepFromTheSurfaceHitsAtOnceInwardAndNeverOutward) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = sample();
    const SurfaceQuery q = shape->query(p);
    Vec3 surface = p - q.distance * q.normal;
    const double rounding = shape->query(surface).distance;
    if (rounding < 0.0) surface -= 4.0 * rounding * q.normal;
    if (shape->query(surface).distance < 0.0) continue;
    const auto inward = shape->sweep(surface, surface - 0.02 * q.normal);
    ASSERT_TRUE(inward);
    EXPECT_LT(inward->fraction, 1e-12);
    EXPECT_FALSE(shape->sweep(surface + 1e-12 * q.normal, surface + q.normal));
  }
}

TEST_P(Shape, VolumeAndInertiaAgreeWithAQuadrature) {
  if (shape->volume() == 0.0) GTEST_SKIP() << "a plane has no volume";
  const Box box = shape->bounds();
  const int n = 100;
  double count = 0.0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Vec3 p = box.min + ((Vec3(i, j, k).array() + 0.5) / n * box.size().array()).matrix();
        if (shape->query(p).distance > 0.0) continue;
        ++count;
        inertia += p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose();
      }
  EXPECT_NEAR(count / (n * n * n) * box.size().prod() / shape->volume(), 1.0, 2e-3);
  EXPECT_LT((inertia / count - shape->unit_inertia()).norm(), 2e-3 * shape->unit_inertia().norm());
}

TEST_P(Shape, BoundsHoldTheSurface) {
  const Box box = shape->bounds();
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = sample();
    const SurfaceQuery q = shape->query(p);
    const Vec3 surface = p - q.distance * q.normal;
    EXPECT_TRUE((surface.array() >= box.min.array() - 1e-14).all());
    EXPECT_TRUE((surface.array() <= box.max.array() + 1e-14).all());
  }
}

INSTANTIATE_TEST_SUITE_P(All, Shape, testing::ValuesIn(cases));

TEST(ShapeByHand, DistancesAndNormalsInTheSmallestCases) {
  const auto box = make_box({1.0, 2.0, 3.0});
  EXPECT_EQ(box->query({0.0, 0.0, 0.0}).distance, -1.0);
  EXPECT_EQ(box->query({0.0, 0.0, 0.0}).normal, Vec3::UnitX());
  EXPECT_EQ(box->query({-2.0, 0.0, 0.0}).normal, -Vec3::UnitX());
  EXPECT_DOUBLE_EQ(box->query({2.0, 3.0, 4.0}).distance, std::sqrt(3.0));
  const auto sphere = make_sphere(2.0);
  EXPECT_EQ(sphere->query(Vec3::Zero()).distance, -2.0);
  EXPECT_EQ(sphere->query(Vec3::Zero()).normal, Vec3::UnitY());
  const auto capsule = make_capsule(0.5, 1.0);
  EXPECT_DOUBLE_EQ(capsule->query({0.0, 2.0, 0.0}).distance, 0.5);
  EXPECT_EQ(capsule->query({0.0, 0.25, 0.0}).normal, Vec3::UnitX());
  const auto plane = make_plane({0.0, 4.0, 0.0}, 0.25);
  EXPECT_DOUBLE_EQ(plane->query({5.0, 1.0, -3.0}).distance, 0.75);
}

TEST(ShapeByHand, AThinPlateIsNotJumpedOver) {
  const auto plate = make_box({1.0, 1e-6, 1.0});
  const auto hit = plate->sweep({0.2, 100.0, 0.1}, {0.2, -100.0, 0.1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->fraction, 0.5, 1e-7);
  EXPECT_EQ(hit->normal, Vec3::UnitY());
}

TEST(ShapeByHand, SizesThatMakeNoShapeAreRefused) {
  EXPECT_THROW(make_plane(Vec3::Zero(), 0.0), Error);
  EXPECT_THROW(make_sphere(-1.0), Error);
  EXPECT_THROW(make_box({1.0, 0.0, 1.0}), Error);
  EXPECT_THROW(make_capsule(std::nan(""), 1.0), Error);
}

}  // namespace
}  // namespace isochor
