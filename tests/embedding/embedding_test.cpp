#include "core/embedding/embedding.h"

#include <gtest/gtest.h>

#include <random>

#include "core/distance_field/closest_point.h"
#include "core/embedding/tet_locator.h"
#include "core/parallel/parallel.h"
#include "core/smoothing/smoothing.h"
#include "tests/support/lattices.h"

namespace isochor {
namespace {

TetMesh smooth_ball() {
  Progress progress;
  SmoothingOptions options;
  options.iterations = 5;
  return smooth(test::ball_of_cells(10), options, progress).mesh;
}

TriangleSoup random_points(unsigned seed, double reach, int count = 2000) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-reach, reach);
  TriangleSoup soup;
  for (int i = 0; i < count; ++i) soup.positions.emplace_back(place(random), place(random), place(random));
  return soup;
}

double distance_to_tets(const TetMesh& mesh, const Vec3& p) {
  double best = 1e300;
  for (const Tet& t : mesh.tets) {
    bool inside = true;
    for (int f = 0; f < 4; ++f) {
      std::array<Vec3, 4> corner{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]],
                                 mesh.positions[t[3]]};
      corner[f] = p;
      inside = inside && tet_volume(corner[0], corner[1], corner[2], corner[3]) >= 0.0;
    }
    if (inside) return 0.0;
  }
  for (const Triangle& t : mesh.surface)
    best = std::min(
        best,
        (closest_point_on_triangle(p, mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]) - p)
            .norm());
  return best;
}

TEST(Embedding, FindsTheTetOrTheNearestOneLikeBruteForce) {
  const TetMesh mesh = smooth_ball();
  const TriangleSoup points = random_points(11, 7.0, 500);
  Progress progress;
  const Embedding embedding = make_embedding(points, mesh, progress);
  std::int64_t outside = 0;
  for (std::size_t v = 0; v < points.positions.size(); ++v) {
    const double expected = distance_to_tets(mesh, points.positions[v]);
    EXPECT_NEAR(embedding.distance[v], expected, 1e-6);
    outside += expected > 0.0;
    if (expected == 0.0) {
      EXPECT_GE(std::ranges::min(embedding.weights[v]), -1e-9);
    }
  }
  EXPECT_EQ(embedding.outside, outside);
}

TEST(Embedding, TheNearestTetIsTheOneAtThatDistance) {
  const TetMesh mesh = smooth_ball();
  const TetLocator locator(mesh);
  for (const Vec3& p : random_points(5, 20.0, 200).positions) {
    TetLocator::Hint hint;
    const TetLocator::Location found = locator.locate(p, hint);
    if (found.triangle < 0) continue;
    const Triangle& face = mesh.surface[found.triangle];
    for (const std::int32_t v : face) EXPECT_EQ(std::ranges::count(mesh.tets[found.tet], v), 1);
    const Vec3 foot = closest_point_on_triangle(p, mesh.positions[face[0]], mesh.positions[face[1]],
                                                mesh.positions[face[2]]);
    EXPECT_NEAR((foot - p).norm(), found.distance, 1e-12);
  }
}

TEST(Embedding, WeightsSumToExactlyOneInAnyOrder) {
  const TriangleSoup points = random_points(3, 30.0);
  Progress progress;
  const Embedding embedding = make_embedding(points, smooth_ball(), progress);
  for (auto w : embedding.weights) {
    EXPECT_EQ(w[0] + w[1] + w[2] + w[3], 1.0);
    EXPECT_EQ(w[3] + w[1] + (w[2] + w[0]), 1.0);
  }
}

TEST(Embedding, ReproducesAffineMaps) {
  const TetMesh mesh = smooth_ball();
  const TriangleSoup points = random_points(8, 8.0);
  Progress progress;
  const Embedding embedding = make_embedding(points, mesh, progress);
  Eigen::Matrix3d a;
  a << 1.0, 0.3, -0.2, 0.1, 0.7, 0.4, -0.5, 0.2, 1.3;
  const Vec3 shift(10.0, -3.0, 5.0);
  std::vector<Vec3> moved;
  for (const Vec3& x : mesh.positions) moved.emplace_back(a * x + shift);
  std::vector<Vec3> out(points.positions.size());
  apply_embedding(embedding, mesh, moved, out);
  for (std::size_t v = 0; v < out.size(); ++v)
    EXPECT_LT((out[v] - (a * points.positions[v] + shift)).norm(), 1e-11);
}

TEST(Embedding, AMeshVertexIsBoundToItself) {
  const TetMesh mesh = smooth_ball();
  Progress progress;
  const Embedding embedding = make_embedding(TriangleSoup{mesh.positions, {}}, mesh, progress);
  EXPECT_EQ(embedding.outside, 0);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_NEAR(std::ranges::max(embedding.weights[v]), 1.0, 1e-9);
}

TEST(Embedding, AgreesForAnyNumberOfThreads) {
  const TetMesh mesh = smooth_ball();
  const TriangleSoup points = random_points(2, 8.0, 5000);
  Progress progress;
  set_thread_count(1);
  const Embedding one = make_embedding(points, mesh, progress);
  set_thread_count(3);
  const Embedding three = make_embedding(points, mesh, progress);
  set_thread_count(0);
  EXPECT_EQ(one.tet, three.tet);
  EXPECT_EQ(one.weights, three.weights);
}

}  // namespace
}  // namespace isochor
