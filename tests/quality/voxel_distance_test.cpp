#include "core/quality/voxel_distance.h"

#include <gtest/gtest.h>

#include <random>

#include "core/pipeline/advice.h"
#include "tests/support/lattices.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

PseudoVolume empty_volume(const Vec3i& size) {
  PseudoVolume volume;
  volume.grid = {size, 0.5, Vec3(1.0, -2.0, 3.0)};
  volume.inside.assign(volume.grid.count(), 0);
  return volume;
}

/// Straight from the words: the nearest point of any face between a voxel inside and one that is not.
double by_faces(const PseudoVolume& volume, const Vec3& p) {
  const Grid& grid = volume.grid;
  const auto inside = [&](const Vec3i& v) {
    return grid.contains(v.x(), v.y(), v.z()) && volume.inside[grid.index(v.x(), v.y(), v.z())] != 0;
  };
  double best = 1e300;
  for (int k = 0; k < grid.size.z(); ++k)
    for (int j = 0; j < grid.size.y(); ++j)
      for (int i = 0; i < grid.size.x(); ++i)
        for (int axis = 0; axis < 3; ++axis)
          for (const int side : {0, 1}) {
            const Vec3i voxel(i, j, k);
            if (!inside(voxel) || inside(voxel + (2 * side - 1) * Vec3i::Unit(axis))) continue;
            Vec3 low = grid.origin + grid.spacing * voxel.cast<double>(),
                 high = low + Vec3::Constant(grid.spacing);
            low[axis] = high[axis] = low[axis] + side * grid.spacing;
            best = std::min(best, (p - p.cwiseMax(low).cwiseMin(high)).norm());
          }
  return best;
}

TEST(VoxelDistance, IsThatToTheNearestFaceBetweenInsideAndOutside) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.2, 1.2);
  for (const double share : {0.002, 0.05, 0.5, 0.98}) {
    PseudoVolume volume = empty_volume({17, 12, 9});
    const Vec3i size = volume.grid.size;
    for (int k = 1; k + 1 < size.z(); ++k)
      for (int j = 1; j + 1 < size.y(); ++j)
        for (int i = 1; i + 1 < size.x(); ++i)
          volume.inside[volume.grid.index(i, j, k)] = std::bernoulli_distribution(share)(random);
    volume.inside[volume.grid.index(5, 5, 5)] = 1;
    for (int n = 0; n < 200; ++n) {
      const Vec3 at(place(random), place(random), place(random));
      const Vec3 p = volume.grid.origin + volume.grid.spacing * at.cwiseProduct(size.cast<double>());
      EXPECT_NEAR(distance_to_surface(volume, p), by_faces(volume, p), 1e-12);
    }
  }
}

TEST(VoxelDistance, OfVoxelsWithoutASurfaceIsBeyondAll) {
  EXPECT_EQ(distance_to_surface(empty_volume({4, 4, 4}), Vec3(1.3, -1.0, 4.0)), 1e300);
}

TEST(VoxelDistance, IsGivenInDiagonalsOfACell) {
  // A block of 2 × 2 × 2 cells of two voxels each, on voxels that reach two cells higher.
  PseudoVolume volume = empty_volume({12, 12, 12});
  for (int k = 2; k < 10; ++k)
    for (int j = 2; j < 6; ++j)
      for (int i = 2; i < 6; ++i) volume.inside[volume.grid.index(i, j, k)] = 1;
  const TetMesh mesh = make_box_lattice({2, 2, 2}, 1.0, volume.grid.origin + Vec3::Constant(1.0));
  const VoxelDistance distance = voxel_distance(mesh, volume, Progress{});
  EXPECT_DOUBLE_EQ(distance.max_diagonals, 1.0 / std::sqrt(3.0)) << "the top's middle, a cell from the sides";
  EXPECT_DOUBLE_EQ(distance.mean_diagonals, 1.0 / std::sqrt(3.0) / 26.0) << "and no other vertex is off it";
}

TEST(VoxelDistance, TellsTheCapOfAnOpeningFromError) {
  MeshingOptions options;
  options.voxels = 64, options.lattice.cells = 24;
  Progress progress;
  const auto bowl = std::make_shared<const TriangleSoup>(test::sphere(1.0, 0.5));
  const auto model = AuthoringPipeline(bowl).run(options, progress);
  const double diagonal = std::sqrt(3.0) * model->mesh().grid.spacing;
  EXPECT_GT(model->quality.boundary_to_input, 3.0 * diagonal);
  EXPECT_LT(model->quality.to_pseudo_volume.max_diagonals, 0.6);
  EXPECT_LT(model->quality.to_pseudo_volume.mean_diagonals, 0.3);
}

TEST(VoxelDistance, BeyondADiagonalIsWarnedOf) {
  MeshingOptions options;
  options.voxels = 48, options.lattice.cells = 12;
  Progress progress;
  Model model =
      *AuthoringPipeline(std::make_shared<const TriangleSoup>(test::sphere(1.0))).run(options, progress);
  ASSERT_TRUE(model.warnings.empty());
  add_warnings(model);
  EXPECT_TRUE(model.warnings.empty());
  model.quality.to_pseudo_volume.max_diagonals = 1.2;
  add_warnings(model);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("up to 1.2 cell diagonals from the pseudo volume"), std::string::npos);
}

}  // namespace
}  // namespace isochor
