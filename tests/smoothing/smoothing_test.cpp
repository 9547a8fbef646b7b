#include "core/smoothing/smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/parallel/parallel.h"
#include "core/quality/quality.h"
#include "core/smoothing/boundary_graph.h"
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

/// Largest distance between a mesh and its mirror image in the plane x = 0, vertex by lattice node.
double mirror_error(const TetMesh& mesh) {
  std::map<std::array<std::int32_t, 3>, Vec3> at;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) at[mesh.nodes[v]] = mesh.positions[v];
  double error = 0.0;
  for (const auto& [node, x] : at) {
    const Vec3 y = at.at({mesh.grid.size.x() - node[0], node[1], node[2]});
    error = std::max(error, (x - Vec3(-y.x(), y.y(), y.z())).norm());
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

TEST(Smoothing, OfASingleCellIsKnownByHand) {
  // On the cube's graph U maps corners c to −(2/3)c, so U² is (4/9)c and a step scales by 1 − μ·4/9; the
  // rescaling undoes it.
  const TetMesh cube = make_box_lattice({1, 1, 1}, 2.0, Vec3::Constant(-1.0));
  const Smoothed result = smoothed(cube, 1);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_NEAR((result.mesh.positions[v] - cube.positions[v]).norm(), 0.0, 1e-15);
  EXPECT_NEAR(result.largest_shrinkage, 1.0 - std::pow(1.0 - 0.25 * 4.0 / 9.0, 3), 1e-15);
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

TEST(Smoothing, AxisAlignedUmbrellaKeepsMirrorSymmetryAndTheOtherDoesNot) {
  for (const TetMesh& mesh : {test::ball_of_cells(12), test::torus_of_cells(16),
                              test::tets_of({8, 8, 8}, [](const Vec3& x) { return x.lpNorm<1>() < 4.0; })}) {
    EXPECT_LT(mirror_error(smoothed(mesh, 2).mesh), 1e-13);
    EXPECT_LT(mirror_error(smoothed(mesh, 20).mesh), 1e-12);  // the limiter at work
    SmoothingOptions all;
    all.edges = UmbrellaEdges::all;
    Progress progress;
    const TetMesh other = smooth(mesh, all, progress).mesh;
    const Vec3 swapped_error = [&] {
      // Exchanging x and y maps the lattice onto itself but not the diagonals of its faces' triangles.
      std::map<std::array<std::int32_t, 3>, Vec3> at;
      for (std::size_t v = 0; v < other.positions.size(); ++v) at[other.nodes[v]] = other.positions[v];
      Vec3 worst = Vec3::Zero();
      for (const auto& [n, x] : at) {
        const int s = mesh.grid.size.x();
        const Vec3 y = at.at({s - n[1], n[0], n[2]});
        worst = worst.cwiseMax((Vec3(y.y(), -y.x(), y.z()) - x).cwiseAbs());
      }
      return worst;
    }();
    EXPECT_GT(swapped_error.maxCoeff(), 0.0);
  }
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

TEST(Smoothing, RefusesParametersOutOfRange) {
  const TetMesh mesh = test::ball_of_cells(4);
  EXPECT_THROW(smoothed(mesh, 21), Error);
  EXPECT_THROW(smoothed(mesh, 2, 0.5), Error);
  EXPECT_THROW(smoothed(mesh, 2, 0.25, 60.0), Error);
}

}  // namespace
}  // namespace isochor
