#include "core/smoothing/smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "core/parallel/cancel_scope.h"
#include "core/parallel/parallel.h"
#include "core/quality/quality.h"
#include "core/smoothing/boundary_graph.h"
#include "core/smoothing/limiter.h"
#include "core/smoothing/rescale.h"
#include "tests/support/lattices.h"

namespace isochor {
namespace {

Smoothed smoothed(const TetMesh& mesh, int iterations, double mu = 0.25, double floor = 20.0) {
  SmoothingOptions options;
  options.iterations = iterations, options.mu = mu, options.min_dihedral_deg = floor;
  Progress progress;
  return smooth(mesh, options, progress);
}

double smallest_angle(const TetMesh& mesh) {
  return std::ranges::min(tet_quality(mesh.positions, mesh.tets).min_dihedral_deg);
}

/// Largest distance between a mesh and its mirror image in the middle plane of its nodes along x, vertex by
/// lattice node.
double mirror_error(const TetMesh& mesh) {
  std::map<std::array<std::int32_t, 3>, Vec3> at;
  std::int32_t low = mesh.nodes[0][0], high = low;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    at[mesh.nodes[v]] = mesh.positions[v];
    low = std::min(low, mesh.nodes[v][0]), high = std::max(high, mesh.nodes[v][0]);
  }
  const double sum = 2.0 * mesh.grid.origin.x() + mesh.grid.spacing * (low + high);
  double error = 0.0;
  for (const auto& [node, x] : at) {
    const Vec3 y = at.at({low + high - node[0], node[1], node[2]});
    error = std::max(error, (x - Vec3(sum - y.x(), y.y(), y.z())).norm());
  }
  return error;
}

TEST(BoundaryGraph, OfACubeHasItsEdges) {
  const TetMesh cube = make_box_lattice({1, 1, 1}, 1.0, Vec3::Zero());
  const BoundaryGraph aligned = make_boundary_graph(cube, UmbrellaEdges::axis_aligned);
  EXPECT_EQ(aligned.vertices.size(), 8u);
  EXPECT_EQ(aligned.neighbors.size(), 2u * 12);
  const BoundaryGraph all = make_boundary_graph(cube, UmbrellaEdges::all);
  EXPECT_EQ(all.neighbors.size(), 2u * (12 + 6));
}

TEST(BoundaryGraph, CountsAnEdgeOfFourFacesOnce) {
  const TetMesh hinge =
      test::tets_of({2, 2, 2}, [](const Vec3& x) { return x.z() > 0 && x.x() * x.y() > 0; });
  const BoundaryGraph graph = make_boundary_graph(hinge, UmbrellaEdges::axis_aligned);
  EXPECT_EQ(graph.vertices.size(), 14u);
  EXPECT_EQ(graph.neighbors.size(), 2u * 23);
}

TEST(Smoothing, LeavesASingleCellAlone) {
  // On the cube's graph U maps corners c to −(2/3)c, so U² is (4/9)c: all of that is volume, which is given
  // back.
  const TetMesh cube = make_box_lattice({1, 1, 1}, 2.0, Vec3::Constant(-1.0));
  const Smoothed result = smoothed(cube, 1);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_NEAR((result.mesh.positions[v] - cube.positions[v]).norm(), 0.0, 1e-15);
  EXPECT_NEAR(result.largest_shrinkage, 0.0, 1e-14);
}

TEST(Smoothing, ABranchOneCellThickKeepsItsLength) {
  const TetMesh branch = make_box_lattice({20, 1, 1}, 1.0, Vec3(0, -0.5, -0.5));
  for (const int iterations : {2, 20}) {
    const TetMesh mesh = smoothed(branch, iterations).mesh;
    Box box;
    for (const Vec3& x : mesh.positions) box.extend(x);
    EXPECT_NEAR(box.size().x(), 20.0, 1.0) << iterations;
    EXPECT_LT(smoothed(branch, iterations).largest_shrinkage, 0.01);
  }
}

TEST(Smoothing, LeavesInteriorVerticesAndTopologyAlone) {
  const TetMesh ball = test::ball_of_cells(8);
  const Smoothed result = smoothed(ball, 2);
  EXPECT_EQ(result.mesh.tets, ball.tets);
  EXPECT_EQ(result.mesh.surface, ball.surface);
  EXPECT_EQ(result.mesh.nodes, ball.nodes);
}

TEST(Smoothing, KeepsTheVolumeOfEachComponent) {
  for (const int iterations : {1, 2, 5, 20}) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      const TetMesh mesh = test::random_cells(seed, 0.3);
      const VertexComponents components = vertex_components(mesh);
      const std::vector<double> before = component_volumes(mesh, components);
      const std::vector<double> after = component_volumes(smoothed(mesh, iterations).mesh, components);
      for (int c = 0; c < components.count; ++c) EXPECT_NEAR(after[c] / before[c], 1.0, 1e-12);
    }
  }
}

TEST(Smoothing, KeepsTheVolumeFarFromTheOrigin) {
  TetMesh mesh = test::ball_of_cells(8);
  const Vec3 offset(1e4, -3e4, 7e3);
  for (Vec3& x : mesh.positions) x += offset;
  mesh.grid.origin += offset;
  EXPECT_NEAR(total_volume(smoothed(mesh, 3).mesh) / total_volume(mesh), 1.0, 1e-12);
}

TEST(Smoothing, KeepsTheFloorWhateverTheParameters) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    const TetMesh mesh = test::random_cells(seed, 0.5);
    for (const int iterations : {1, 2, 7, 20})
      for (const double mu : {0.1, 0.25, 0.4})
        for (const double floor : {5.0, 20.0, 45.0})
          EXPECT_GE(smallest_angle(smoothed(mesh, iterations, mu, floor).mesh), floor)
              << "seed " << seed << ", " << iterations << " iterations, mu " << mu;
  }
}

TEST(Smoothing, NeverInvertsWithoutAFloor) {
  for (const TetMesh& mesh :
       {test::random_cells(1, 0.5), test::ball_of_cells(10), test::torus_of_cells(16)}) {
    const TetQuality quality = [&] {
      const TetMesh result = smoothed(mesh, 20, 0.4, 0.0).mesh;
      return tet_quality(result.positions, result.tets);
    }();
    EXPECT_GT(std::ranges::min(quality.scaled_jacobian), 0.0F);
  }
}

TEST(Smoothing, DefaultsLeave29DegreesOnRoundBodies) {
  for (const TetMesh& mesh : {test::ball_of_cells(10), test::ball_of_cells(24), test::torus_of_cells(24)}) {
    const Smoothed result = smoothed(mesh, 2);
    EXPECT_GE(smallest_angle(result.mesh), 29.0);
    EXPECT_EQ(result.limited_vertices, 0);
  }
}

TEST(Smoothing, DefaultsLeave29DegreesOnRaggedBodies) {
  int ragged = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const TetMesh mesh = test::random_cells(seed, 0.5);
    EXPECT_GE(smallest_angle(smoothed(mesh, 2).mesh), 29.0) << "seed " << seed;
    ragged += smallest_angle(smoothed(mesh, 2, 0.25, 0.0).mesh) < 29.0;
  }
  EXPECT_GT(ragged, 0);
}

TEST(Smoothing, KeepsTheSymmetryOfACentredModel) {
  for (const TetMesh& mesh : {test::ball_of_cells(12), test::torus_of_cells(16),
                              test::tets_of({8, 8, 8}, [](const Vec3& x) { return x.lpNorm<1>() < 4.0; })}) {
    EXPECT_LT(mirror_error(smoothed(mesh, 2).mesh), 1e-13);
    EXPECT_LT(mirror_error(smoothed(mesh, 20).mesh), 1e-12);  // the limiter at work
  }
}

// A part of odd width, such as a table's leg, has a mirror plane of its own that exchanges the two patterns
// of tets. Axis-aligned edges do not see the patterns; the diagonals of all edges do (Diziol 2009, Figure 2).
TEST(Smoothing, OnlyAxisAlignedEdgesKeepTheSymmetryOfAPartOfOddWidth) {
  const auto inside = [](const Vec3& x) { return x.x() > 0 && x.x() < 3 && x.y() > -2 && x.y() < 1; };
  const TetMesh leg = test::tets_of({8, 8, 8}, inside);
  EXPECT_LT(mirror_error(smoothed(leg, 2).mesh), 1e-13);
  SmoothingOptions all;
  all.edges = UmbrellaEdges::all;
  Progress progress;
  EXPECT_GT(mirror_error(smooth(leg, all, progress).mesh), 0.01);
}

TEST(Smoothing, GivesTheSameBitsForAnyNumberOfThreads) {
  const TetMesh mesh = test::random_cells(3, 0.5);
  set_thread_count(1);
  const TetMesh one = smoothed(mesh, 6, 0.4).mesh;
  set_thread_count(3);
  const TetMesh three = smoothed(mesh, 6, 0.4).mesh;
  set_thread_count(0);
  EXPECT_EQ(one.positions, three.positions);
}

TEST(Smoothing, EachOfItsPartsEndsWithTheScopeOfItsThread) {
  const TetMesh mesh = make_box_lattice({20, 20, 20}, 0.1, Vec3::Zero());
  const BoundaryGraph graph = make_boundary_graph(mesh, UmbrellaEdges::axis_aligned);
  const VertexComponents components = vertex_components(mesh);
  const std::atomic<bool> cancel{true};
  const Progress progress({}, &cancel);
  const CancelScope scope(progress);
  EXPECT_THROW(make_boundary_graph(mesh, UmbrellaEdges::axis_aligned), Error);
  EXPECT_THROW(vertex_components(mesh), Error);
  EXPECT_THROW(component_volumes(mesh, components), Error);
  EXPECT_THROW(MoveLimiter(mesh, graph), Error);
}

TEST(Smoothing, RefusesParametersOutOfRange) {
  const TetMesh mesh = test::ball_of_cells(4);
  EXPECT_THROW(smoothed(mesh, 21), Error);
  EXPECT_THROW(smoothed(mesh, 2, 0.5), Error);
  EXPECT_THROW(smoothed(mesh, 2, 0.25, 60.0), Error);
}

}  // namespace
}  // namespace isochor
