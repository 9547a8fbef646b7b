#include "core/lattice/lattice.h"

#include <gtest/gtest.h>

#include <random>

namespace isochor {
namespace {

/// A pseudo volume on n voxels of size 1 with padding 4 around the box [0, extent]³.
PseudoVolume volume_on(const Vec3i& extent, auto&& is_inside) {
  PseudoVolume volume;
  volume.grid = Grid{extent + Vec3i::Constant(8), 1.0, Vec3::Constant(-4.0)};
  volume.thresholds.d_in = 1.0;
  for (int k = 0; k < volume.grid.size.z(); ++k)
    for (int j = 0; j < volume.grid.size.y(); ++j)
      for (int i = 0; i < volume.grid.size.x(); ++i)
        volume.inside.push_back(is_inside(volume.grid.center(i, j, k)));
  return volume;
}

Box box_of(const Vec3i& extent) {
  return Box{Vec3::Zero(), extent.cast<double>()};
}

TEST(LatticeGrid, HasEvenCountsAndIsCentred) {
  const Box box{Vec3(1, 2, 3), Vec3(11, 8.9, 3)};
  for (const int cells : {2, 5, 9, 24}) {
    const Grid grid = lattice_grid(box, cells, 0.3);
    EXPECT_DOUBLE_EQ(grid.spacing, 10.0 / (cells + cells % 2));
    EXPECT_TRUE((grid.origin + 0.5 * grid.spacing * grid.size.cast<double>()).isApprox(box.center(), 1e-14));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(grid.size[axis] % 2, 0);
      EXPECT_GE(grid.size[axis] * grid.spacing, box.size()[axis] + 0.6);
    }
  }
}

TEST(Lattice, DensityCountsVoxelCentres) {
  // Cells of 2.5 voxels: their boundaries pass through voxel centres, which then count for both sides.
  const Vec3i extent(20, 20, 20);
  std::mt19937 random(7);
  const PseudoVolume volume = volume_on(extent, [&](const Vec3&) { return random() % 2; });
  Progress progress;
  for (const int cells : {8, 6, 10}) {
    LatticeOptions options;
    options.cells = cells;
    options.fit_volume = false;
    const Lattice lattice = make_lattice(volume, box_of(extent), options, progress);
    for (int ck = 0; ck < lattice.grid.size.z(); ++ck)
      for (int cj = 0; cj < lattice.grid.size.y(); ++cj)
        for (int ci = 0; ci < lattice.grid.size.x(); ++ci) {
          const Vec3 low = lattice.grid.origin + lattice.grid.spacing * Vec3(ci, cj, ck);
          const auto within = [&](int voxel, int axis) {
            const double at = voxel + 0.5 - low[axis];
            return at >= -1e-9 && at <= lattice.grid.spacing + 1e-9;
          };
          int all = 0, inside = 0;
          for (int k = -40; k < 60; ++k)
            for (int j = -40; within(k, 2) && j < 60; ++j)
              for (int i = -40; within(j, 1) && i < 60; ++i) {
                if (!within(i, 0)) continue;
                ++all;
                if (volume.grid.contains(i + 4, j + 4, k + 4))
                  inside += volume.inside[volume.grid.index(i + 4, j + 4, k + 4)];
              }
          ASSERT_FLOAT_EQ(lattice.density[lattice.grid.index(ci, cj, ck)], static_cast<float>(inside) / all);
        }
  }
}

TEST(Lattice, ABoxOfVoxelsBecomesItsCells) {
  const Vec3i extent(24, 12, 6);
  const PseudoVolume volume = volume_on(extent, [&](const Vec3& x) {
    return (x.array() > 0).all() && (x.array() < extent.cast<double>().array()).all();
  });
  LatticeOptions options;
  options.cells = 8;  // of 3 voxels
  Progress progress;
  const Lattice lattice = make_lattice(volume, box_of(extent), options, progress);
  EXPECT_EQ(lattice.kept_count, 8 * 4 * 2);
  EXPECT_EQ(lattice.components, 1);
  EXPECT_EQ(lattice.filled_count, 0);
}

TEST(Lattice, FitsTheVolumeOfASlabWhoseSidesFallBetweenCells) {
  const Vec3i extent(96, 96, 62);  // 15.5 cells of 4 voxels become 16
  const auto solid = [&](const Vec3& p) {
    return (p.array() > 0.0).all() && (p.array() < extent.cast<double>().array()).all();
  };
  Progress progress;
  LatticeOptions options;
  options.fit_volume = false;
  const Lattice plain = make_lattice(volume_on(extent, solid), box_of(extent), options, progress);
  options.fit_volume = true;
  const Lattice fitted = make_lattice(volume_on(extent, solid), box_of(extent), options, progress);
  EXPECT_EQ(fitted.kept, plain.kept);
  const auto volume = [&](const Lattice& lattice) {
    return static_cast<double>(lattice.kept_count) * std::pow(lattice.grid.spacing, 3) /
           extent.cast<double>().prod();
  };
  EXPECT_NEAR(volume(plain), 16.0 / 15.5, 1e-12);
  EXPECT_NEAR(volume(fitted), 1.02, 1e-12);
  EXPECT_NEAR(fitted.grid.spacing, fitted.scale * plain.grid.spacing, 1e-12);
  const auto middle = [](const Grid& grid) -> Vec3 {
    return grid.origin + 0.5 * grid.spacing * grid.size.cast<double>();
  };
  EXPECT_LT((middle(fitted.grid) - middle(plain.grid)).norm(), 1e-9);

  const auto leaf = [&](const Vec3& p) { return solid(p) && p.z() > 29.0 && p.z() < 33.0; };
  options.density = 0.2;
  EXPECT_EQ(make_lattice(volume_on(extent, leaf), box_of(extent), options, progress).scale, 1.0);
}

/// A hollow box with walls of two cells of which one is kept, from 30 to 31 cells off the middle: twice its
/// volume would put it where it is not.
TEST(Lattice, MovesTheSidesOfAWideShellByHalfACell) {
  const Vec3i extent = Vec3i::Constant(128);
  const auto shell = [](const Vec3& p) {
    const double r = (p - Vec3::Constant(64.0)).cwiseAbs().maxCoeff();
    return r > 59.0 && r < 63.0;
  };
  Progress progress;
  LatticeOptions options;
  options.cells = 64;
  const Lattice lattice = make_lattice(volume_on(extent, shell), box_of(extent), options, progress);
  EXPECT_NEAR(30.5 * (lattice.scale - 1.0), 0.5, 0.02);
}

TEST(Lattice, LargestOnlyDropsTheRest) {
  const Vec3i extent(24, 12, 12);
  const PseudoVolume volume = volume_on(extent, [](const Vec3& x) {
    return x.x() > 0 && x.y() > 0 && x.z() > 0 && x.z() < 12 && x.y() < 12 &&
           (x.x() < 6 || (x.x() > 9 && x.x() < 24));
  });
  LatticeOptions options;
  options.cells = 8;
  Progress progress;
  EXPECT_EQ(make_lattice(volume, box_of(extent), options, progress).components, 2);
  options.largest_only = true;
  const Lattice lattice = make_lattice(volume, box_of(extent), options, progress);
  EXPECT_EQ(lattice.components, 1);
  EXPECT_EQ(lattice.kept_count, 5 * 4 * 4);
}

TEST(Lattice, RefusesMoreCellsThanHalfTheVoxels) {
  const Vec3i extent(20, 20, 20);
  const PseudoVolume volume = volume_on(extent, [](const Vec3&) { return false; });
  LatticeOptions options;
  options.cells = 12;
  Progress progress;
  try {
    make_lattice(volume, box_of(extent), options, progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid_argument);
    ASSERT_EQ(error.details().size(), 1u);
    EXPECT_EQ(error.details()[0].pointer, "/cells");
    EXPECT_EQ(error.details()[0].max, 10.0);
  }
}

}  // namespace
}  // namespace isochor
