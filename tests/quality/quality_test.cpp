#include "core/quality/quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/lattices.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

QualitySummary summary_of(const TetMesh& mesh, const TriangleSoup& soup) {
  Progress progress;
  const Embedding embedding = make_embedding(soup, mesh, progress);
  const DistanceField field = make_distance_field(soup, {32, 4}, progress);
  return summarize_quality(mesh, MeasuredSoup(soup), embedding, field, progress);
}

TEST(TetQuality, OfKnownTets) {
  const std::vector<Vec3> x{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1},  // regular
                            {0, 0, 0}, {1, 0, 0},   {0, 1, 0},   {0, 0, 1}};   // a cube's corner
  const std::vector<Tet> tets{{0, 1, 2, 3}, {1, 0, 2, 3}, {4, 5, 6, 7}, {4, 5, 7, 6}, {4, 4, 5, 6}};
  const TetQuality quality = tet_quality(x, tets);
  const int regular = quality.scaled_jacobian[0] > 0 ? 0 : 1;
  EXPECT_NEAR(quality.min_dihedral_deg[regular], 70.528779, 1e-4);
  EXPECT_NEAR(quality.scaled_jacobian[regular], 1.0, 1e-6);
  EXPECT_EQ(quality.min_dihedral_deg[1 - regular], 0.0F);
  EXPECT_NEAR(quality.scaled_jacobian[1 - regular], -1.0, 1e-6);
  EXPECT_NEAR(quality.min_dihedral_deg[2], 54.735610, 1e-4);
  EXPECT_NEAR(quality.scaled_jacobian[2], std::sqrt(2.0) / 2.0, 1e-6);
  EXPECT_EQ(quality.min_dihedral_deg[3], 0.0F);
  EXPECT_EQ(quality.min_dihedral_deg[4], 0.0F);
  EXPECT_EQ(quality.scaled_jacobian[4], 0.0F);
}

TEST(Quality, OfABoxThatIsItsOwnModel) {
  const TetMesh mesh = make_box_lattice({4, 4, 4}, 0.5, Vec3::Zero());
  const QualitySummary summary = summary_of(mesh, test::box(Vec3::Zero(), Vec3::Constant(2.0)));
  EXPECT_NEAR(summary.volume, 8.0, 1e-12);
  EXPECT_EQ(summary.inverted, 0);
  EXPECT_NEAR(summary.min_dihedral_deg, 54.7356, 1e-3);
  EXPECT_DOUBLE_EQ(summary.coverage, 1.0);
  EXPECT_NEAR(summary.boundary_to_input, 0.0, 1e-12);
  EXPECT_NEAR(summary.input_to_boundary, 0.0, 1e-12);
}

TEST(Quality, CoverageIsTheShareOfAreaWithinACell) {
  // The model covers x < 1 of a plate that reaches to x = 4; within one cell (0.25) lies x < 1.25.
  const TetMesh mesh = make_box_lattice({4, 4, 2}, 0.25, Vec3::Zero());
  const TriangleSoup plate = test::patch(1, 1, [](double u, double v) { return Vec3(4 * u, v, 0.25); });
  const QualitySummary summary = summary_of(mesh, plate);
  EXPECT_NEAR(summary.coverage, 1.25 / 4.0, 0.02);
  EXPECT_NEAR(summary.input_to_boundary, 3.0, 0.1);
  EXPECT_NEAR(summary.boundary_to_input, 0.25, 1e-12);
}

TEST(Quality, VerticesOfNoTriangleAreNoInput) {
  TriangleSoup soup = test::box(Vec3::Zero(), Vec3::Constant(2.0));
  soup.positions.emplace_back(1e6, 0, 0);
  const QualitySummary summary = summary_of(make_box_lattice({4, 4, 4}, 0.5, Vec3::Zero()), soup);
  EXPECT_NEAR(summary.input_to_boundary, 0.0, 1e-12);
}

TEST(Quality, CountsTheBoundaryBeyondACellsDiagonal) {
  // A block of 4 × 4 × 8 cells on a plate: the diagonal is 0.43, so that only two of nine layers are near.
  const TetMesh mesh = make_box_lattice({4, 4, 8}, 0.25, Vec3::Zero());
  const TriangleSoup plate = test::patch(1, 1, [](double u, double v) { return Vec3(u, v, 0.0); });
  const QualitySummary summary = summary_of(mesh, plate);
  EXPECT_DOUBLE_EQ(summary.boundary_beyond, (6 * 16 + 25) / (25 + 7 * 16 + 25.0));
  EXPECT_NEAR(summary.boundary_to_input, 2.0, 1e-12);
}

TEST(Quality, OnePlantedInversionIsSeen) {
  TetMesh mesh = test::ball_of_cells(6);
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  const QualitySummary summary = summary_of(mesh, test::sphere(3.0));
  EXPECT_EQ(summary.inverted, 1);
  EXPECT_EQ(summary.min_dihedral_deg, 0.0);
  EXPECT_LT(summary.min_scaled_jacobian, 0.0);
}

}  // namespace
}  // namespace isochor
