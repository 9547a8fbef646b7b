#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {
namespace {

/// Rows are ∂V/∂x of the tets, of a cube of cells whose vertices are moved at random by a twentieth of a
/// cell.
Eigen::MatrixXd tet_rows(const TetMesh& mesh) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);
  std::vector<Vec3> x = mesh.positions;
  for (Vec3& p : x) p += Vec3(noise(random), noise(random), noise(random));
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(std::ssize(mesh.tets), 3 * std::ssize(x));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& [a, b, c, d] = mesh.tets[t];
    const auto set = [&](int vertex, const Vec3& u, const Vec3& v) {
      rows.block<1, 3>(t, 3 * vertex) = u.cross(v).transpose() / 6.0;
    };
    set(b, x[c] - x[a], x[d] - x[a]);
    set(c, x[d] - x[a], x[b] - x[a]);
    set(d, x[b] - x[a], x[c] - x[a]);
    set(a, x[d] - x[b], x[c] - x[b]);
  }
  return rows;
}

Eigen::MatrixXd cell_rows(const TetMesh& mesh, const Eigen::MatrixXd& tets) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(std::ssize(mesh.cells), tets.cols());
  for (Eigen::Index t = 0; t < tets.rows(); ++t) rows.row(t / 5) += tets.row(t);
  return rows;
}

/// Motions that keep all volumes to the first order.
Eigen::Index freedoms(const Eigen::MatrixXd& rows) {
  return rows.cols() - Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(rows.transpose()).rank();
}

class Locking : public testing::TestWithParam<std::pair<int, int>> {};

// One volume a cell leaves three freedoms a vertex but one a cell; one a tet leaves next to none inside, five
// of them taking three [Diziol 2009, 5].
TEST_P(Locking, AVolumeATetLeavesAFewMotionsAtTheSurface) {
  const auto [n, left] = GetParam();
  const TetMesh mesh = make_box_lattice({n, n, n}, 1.0, Vec3::Zero());
  const Eigen::MatrixXd tets = tet_rows(mesh);
  const int all = 3 * (n + 1) * (n + 1) * (n + 1);
  EXPECT_EQ(freedoms(cell_rows(mesh, tets)), all - n * n * n);
  EXPECT_EQ(freedoms(tets), left);
}

INSTANTIATE_TEST_SUITE_P(Cubes, Locking,
                         testing::Values(std::pair(2, 41), std::pair(4, 55), std::pair(6, 63)),
                         [](const auto& cube) { return std::to_string(cube.param.first) + "_cells"; });

}  // namespace
}  // namespace isochor
