#include "core/collision/mesh_shape.h"

#include <gtest/gtest.h>

#include "core/collision/manifold.h"
#include "core/mesh_input/read_mesh.h"

namespace isochor {
namespace {

CollisionMesh sample_mesh(const char* name, int voxels, double scale) {
  Progress quiet;
  const PseudoVolumeOptions options;
  const auto soup = read_mesh(std::filesystem::path(ISOCHOR_SAMPLES) / "meshes" / name, quiet);
  const DistanceField field = make_distance_field(soup, {voxels, field_padding}, quiet);
  return {field, make_pseudo_volume(field, options, quiet), scale, true};
}

/// The sample torus lies about some axis through its centre: radii 0.35 and 0.15.
TEST(MeshShape, DistancesOfATorusAreItsOwn) {
  const double scale = 2.0;
  const CollisionMesh torus = sample_mesh("torus.obj", 64, scale);
  const double h = scale / 64.0;
  int axis = 0;
  torus.bounds().size().minCoeff(&axis);
  const auto distance = [&](const Vec3& p) {
    Vec3 flat = p;
    flat[axis] = 0.0;
    return std::hypot(flat.norm() - scale * 0.35, p[axis]) - scale * 0.15;
  };
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p = Vec3(std::sin(1.0 * i), std::sin(1.7 * i + 1.0), 0.5 * std::sin(2.3 * i)) * scale * 0.5;
    if (std::abs(distance(p)) < 2.0 * h)
      worst = std::max(worst, std::abs(torus.query(p).distance - distance(p)));
  }
  EXPECT_LT(worst, 0.5 * h);
  EXPECT_GT(worst, 0.0);
}

TEST(MeshShape, MassPropertiesOfABallAreItsOwn) {
  const CollisionMesh ball = sample_mesh("sphere.obj", 64, 2.0);  // radius 1
  EXPECT_NEAR(ball.volume(), 4.18879, 0.03 * 4.18879);
  EXPECT_LT((ball.unit_inertia() - 0.4 * Eigen::Matrix3d::Identity()).norm(), 0.02);
  EXPECT_LT(ball.center().norm(), 0.01);
}

TEST(MeshShape, NothingPassesThrough) {
  const CollisionMesh ball = sample_mesh("sphere.obj", 32, 2.0);
  const auto hit = ball.sweep({-100.0, 0.1, 0.0}, {100.0, 0.1, 0.0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(-100.0 + 200.0 * hit->fraction, -std::sqrt(1.0 - 0.01), 0.02);
  EXPECT_LT(hit->normal.x(), -0.95);
  EXPECT_FALSE(ball.sweep({-100.0, 1.2, 0.0}, {100.0, 1.2, 0.0}));
}

TEST(MeshShape, ASweepOfAnyLengthEnds) {
  const CollisionMesh ball = sample_mesh("sphere.obj", 32, 2.0);
  for (const double far : {1e10, 1e18, 1e200, 1e308}) {
    const auto hit = ball.sweep({-2.0, 0.1, 0.0}, {far, 0.1, 0.0});
    ASSERT_TRUE(hit) << far;
    EXPECT_LT(hit->normal.x(), -0.9) << far;
    EXPECT_FALSE(ball.sweep({2.0, 0.1, 0.0}, {far, 0.1, 0.0})) << far;
  }
  EXPECT_FALSE(ball.sweep({-2.0, 0.0, 0.0}, {std::nan(""), 0.0, 0.0}));
  EXPECT_FALSE(ball.sweep({-2.0, 0.0, 0.0}, {HUGE_VAL, 0.0, 0.0}));
}

/// Of points that are in the ground each counts, whichever comes first: a leg of a table that was not seen
/// while another one touched went in by 15 cm and came out at once, with 30 times its energy.
TEST(MeshShape, TheDeepestPointIsAmongThoseOfAContact) {
  const CollisionMesh table = sample_mesh("table.obj", 64, 1.0);
  const auto ground = make_plane(Vec3::UnitY(), 0.0);
  for (int i = 0; i < 40; ++i) {
    const Pose pose{Vec3::Zero(),
                    rotation_exp(3.0 * Vec3(std::sin(i), std::sin(1.7 * i), std::cos(2.3 * i)))};
    double lowest = HUGE_VAL;
    for (const Vec3& p : table.samples()) lowest = std::min(lowest, pose.to_world(p).y());
    for (const double margin : {1e-6, 0.0, -1e-7}) {
      const Pose sunk{Vec3(0.0, -lowest - 0.1, 0.0), pose.orientation};
      Manifold manifold;
      EXPECT_NEAR(collide({table, sunk}, {*ground, Pose{}}, margin, manifold), -0.1, 1e-12);
      double deepest = HUGE_VAL;
      for (const ManifoldPoint& point : manifold.points()) deepest = std::min(deepest, point.gap());
      EXPECT_NEAR(deepest, -0.1, 1e-12) << i << " " << margin;
    }
  }
}

/// Or it would sink into what it stands on.
TEST(MeshShape, SamplesReachAsFarAsTheMesh) {
  Progress quiet;
  for (const char* name : {"table.obj", "torus.obj"}) {
    const CollisionMesh shape = sample_mesh(name, 128, 1.0);
    EXPECT_LE(shape.samples().size(), 3000U);
    const auto soup = read_mesh(std::filesystem::path(ISOCHOR_SAMPLES) / "meshes" / name, quiet);
    const double voxel = bounding_box(soup).size().maxCoeff() / 128.0;
    double worst = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vec3 direction = Vec3(std::sin(i), std::sin(1.7 * i + 1.0), std::cos(2.3 * i)).normalized();
      double reach = -HUGE_VAL, sampled = -HUGE_VAL;
      for (const Vec3& p : soup.positions) reach = std::max(reach, direction.dot(p - shape.center()));
      for (const Vec3& p : shape.samples()) sampled = std::max(sampled, direction.dot(p));
      worst = std::max(worst, reach - sampled);
    }
    EXPECT_LT(worst, 1.25 * voxel) << name;
  }
}

}  // namespace
}  // namespace isochor
