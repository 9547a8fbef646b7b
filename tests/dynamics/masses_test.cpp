#include "core/dynamics/masses.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/dynamics/cell_volume.h"

namespace isochor {
namespace {

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Masses, ASixthAtTheCentralTetAndATwelfthAtItsApexes) {
  const TetMesh mesh = make_box_lattice({1, 1, 1}, 2.0, Vec3::Zero());
  const std::vector<double> volumes{8.0}, densities{3.0};
  const auto masses = particle_masses(mesh, volumes, densities, MassLumping::lumped);
  for (const int central : {0, 3, 5, 6}) EXPECT_DOUBLE_EQ(masses[central], 4.0);
  for (const int apex : {1, 2, 4, 7}) EXPECT_DOUBLE_EQ(masses[apex], 2.0);
}

TEST(Masses, LumpedOnesAreProportionalToTheGradient) {
  const TetMesh mesh = make_box_lattice({4, 3, 2}, 0.5, Vec3::Zero());
  const auto volumes = cell_volumes(mesh, mesh.positions);
  const auto masses =
      particle_masses(mesh, volumes, std::vector<double>(volumes.size(), 7.0), MassLumping::lumped);
  std::vector<double> pulled(masses.size(), 0.0);
  for (const Cell& cell : mesh.cells) {
    CellCorners corners;
    for (int b = 0; b < 8; ++b) corners[b] = mesh.positions[cell.corners[b]];
    const CellCorners gradient = cell_volume_gradient(corners, cell.parity());
    for (int b = 0; b < 8; ++b) pulled[cell.corners[b]] += gradient[b].norm();
  }
  for (std::size_t i = 0; i < masses.size(); ++i)
    EXPECT_NEAR(masses[i] / pulled[i], masses[0] / pulled[0], 1e-12);
}

TEST(Masses, TheTotalIsDensityTimesVolume) {
  const TetMesh mesh = make_box_lattice({2, 1, 1}, 1.0, Vec3::Zero());
  const std::vector<double> volumes{1.0, 1.0}, densities{1.0, 1e6};
  for (const MassLumping lumping : {MassLumping::lumped, MassLumping::equal})
    EXPECT_NEAR(sum(particle_masses(mesh, volumes, densities, lumping)), 1000001.0, 1e-6);
}

TEST(Masses, EqualOnesAreEqual) {
  const TetMesh mesh = make_box_lattice({3, 3, 3}, 1.0, Vec3::Zero());
  const std::vector<double> ones(27, 1.0);
  for (const double mass : particle_masses(mesh, ones, ones, MassLumping::equal))
    EXPECT_NEAR(mass, 27.0 / 64.0, 1e-15);
}

}  // namespace
}  // namespace isochor
