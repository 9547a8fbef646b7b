#include "core/dynamics/cell_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {
namespace {

CellCorners unit_cube() {
  CellCorners corners;
  for (int b = 0; b < 8; ++b) corners[b] = Vec3(b & 1, b >> 1 & 1, b >> 2 & 1);
  return corners;
}

CellCorners random_cell(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.8, 0.8);
  CellCorners corners = unit_cube();
  for (Vec3& corner : corners) corner += Vec3(shift(random), shift(random), shift(random));
  return corners;
}

double sum_of_tets(const CellCorners& corners, int parity) {
  double sum = 0.0;
  for (const auto& tet : five_tets(parity))
    sum += tet_volume(corners[tet[0]], corners[tet[1]], corners[tet[2]], corners[tet[3]]);
  return sum;
}

class CellVolume : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Parity, CellVolume, testing::Values(0, 1));

TEST_P(CellVolume, OfTheUnitCubeIsOneAndMirroringFlipsItsSign) {
  CellCorners corners = unit_cube();
  EXPECT_DOUBLE_EQ(cell_volume(corners, GetParam()), 1.0);
  for (Vec3& corner : corners) corner.x() = -corner.x();
  EXPECT_DOUBLE_EQ(cell_volume(corners, GetParam()), -1.0);
}

TEST_P(CellVolume, GradientOfTheUnitCubeIsTwiceAsLargeAtCentralCorners) {
  const CellCorners gradient = cell_volume_gradient(unit_cube(), GetParam());
  const auto& central = five_tets(GetParam())[0];
  for (int b = 0; b < 8; ++b) {
    const bool is_central = std::find(central.begin(), central.end(), b) != central.end();
    const Vec3 outward = Vec3(b & 1, b >> 1 & 1, b >> 2 & 1) - Vec3::Constant(0.5);
    EXPECT_LT((gradient[b] - outward * (is_central ? 2.0 / 3.0 : 1.0 / 3.0)).norm(), 1e-15);
  }
}

TEST_P(CellVolume, IsTheSumOfItsFiveTets) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const CellCorners corners = random_cell(seed);
    EXPECT_NEAR(cell_volume(corners, GetParam()), sum_of_tets(corners, GetParam()), 1e-14);
  }
}

// V is linear in each single coordinate, so central differences have no truncation error.
TEST_P(CellVolume, GradientIsExactAgainstFiniteDifferences) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const CellCorners corners = random_cell(seed);
    const CellCorners gradient = cell_volume_gradient(corners, GetParam());
    for (int b = 0; b < 8; ++b)
      for (int axis = 0; axis < 3; ++axis) {
        CellCorners above = corners, below = corners;
        above[b][axis] += 0.5;
        below[b][axis] -= 0.5;
        EXPECT_NEAR(gradient[b][axis], sum_of_tets(above, GetParam()) - sum_of_tets(below, GetParam()),
                    2e-14);
      }
  }
}

// Euler's theorem on a homogeneous function of degree 3, and invariance under translation and rotation.
TEST_P(CellVolume, GradientIsHomogeneousAndCarriesNoForceAndNoTorque) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const CellCorners corners = random_cell(seed);
    const CellCorners gradient = cell_volume_gradient(corners, GetParam());
    double moment = 0.0;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (int b = 0; b < 8; ++b) {
      moment += corners[b].dot(gradient[b]);
      force += gradient[b];
      torque += corners[b].cross(gradient[b]);
    }
    EXPECT_NEAR(moment, 3.0 * cell_volume(corners, GetParam()), 1e-13);
    EXPECT_LT(force.norm(), 1e-14);
    EXPECT_LT(torque.norm(), 1e-14);
  }
}

}  // namespace
}  // namespace isochor
