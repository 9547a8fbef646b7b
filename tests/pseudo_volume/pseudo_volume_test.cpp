#include "core/pseudo_volume/pseudo_volume.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/fields.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

PseudoVolume made(const DistanceField& field, Crossing crossing = Crossing::automatic, int rays = 26) {
  PseudoVolumeOptions options;
  options.crossing = crossing, options.rays = rays;
  Progress progress;
  return make_pseudo_volume(field, options, progress);
}

double volume_of(const TriangleSoup& soup, int voxels, Crossing crossing = Crossing::automatic,
                 int rays = 26) {
  Progress progress;
  const DistanceField field = make_distance_field(soup, {voxels, 4}, progress);
  return static_cast<double>(made(field, crossing, rays).inside_count) * std::pow(field.grid.spacing, 3);
}

// Along an edge the distance to both faces is constant, rays in either face's plane find no maximum on the
// way, and the other directions are no majority.
TEST(PseudoVolume, ABoxHasExactlyItsVoxelsAwayFromItsEdges) {
  const Vec3 half(9.0, 6.0, 7.0);
  const DistanceField field =
      test::field_of({26, 20, 22}, [&](const Vec3& x) { return test::box_distance(x, half); });
  for (const Crossing crossing : {Crossing::automatic, Crossing::at_maximum})
    for (const int rays : {14, 26}) {
      const PseudoVolume volume = made(field, crossing, rays);
      std::int64_t at = 0;
      for (int k = 0; k < 22; ++k)
        for (int j = 0; j < 20; ++j)
          for (int i = 0; i < 26; ++i, ++at) {
            const Vec3 q = field.grid.center(i, j, k).cwiseAbs() - half;
            const bool at_edge = (q.array().abs() < 3.0).count() > 1;
            if (!at_edge) {
              ASSERT_EQ(volume.inside[at] != 0, q.maxCoeff() < 0.0)
                  << rays << " rays at " << i << " " << j << " " << k;
            }
          }
    }
}

TEST(PseudoVolume, AtThresholdASlabGrowsBeyondItsSurface) {
  // The letter takes entries and exits early: where the grazing rays break the tie, voxels outside are added.
  const Vec3 half(9.0, 6.0, 7.0);
  const DistanceField field =
      test::field_of({26, 20, 22}, [&](const Vec3& x) { return test::box_distance(x, half); });
  EXPECT_GT(made(field, Crossing::at_threshold).inside_count, made(field, Crossing::at_maximum).inside_count);
}

TEST(PseudoVolume, VolumesOfClosedShapes) {
  constexpr double pi = std::numbers::pi;
  EXPECT_NEAR(volume_of(test::sphere(0.5), 64) / (pi / 6.0), 1.0, 0.03);
  EXPECT_NEAR(volume_of(test::torus(0.35, 0.15), 96) / (2.0 * pi * pi * 0.35 * 0.15 * 0.15), 1.0, 0.03);
  EXPECT_NEAR(volume_of(test::box(Vec3::Zero(), Vec3::Ones()), 64), 1.0, 0.002);
}

TEST(PseudoVolume, AHemisphereWithoutItsDiscIsFilledBy26Directions) {
  const double expected = std::numbers::pi / 12.0;
  const double few = volume_of(test::sphere(0.5, 0.5), 64, Crossing::automatic, 6);
  const double all = volume_of(test::sphere(0.5, 0.5), 64);
  EXPECT_NEAR(all / expected, 1.0, 0.06);
  EXPECT_LE(std::abs(all - expected), std::abs(few - expected) + 1e-3);
}

TEST(PseudoVolume, ASheetVanishesAtMaximumAndIsKeptByTheDefault) {
  Progress progress;
  for (const double degrees : {0.0, 20.0, 33.0}) {
    const DistanceField field = make_distance_field(test::sheet(1.0, degrees), {64, 4}, progress);
    const PseudoVolume kept = made(field);
    EXPECT_LT(made(field, Crossing::at_maximum).inside_count, kept.inside_count / 50) << degrees;
    const double thickness = static_cast<double>(kept.inside_count) * std::pow(field.grid.spacing, 2);
    EXPECT_GT(thickness, 0.9) << degrees;  // voxels; the sheet's side is 1
    EXPECT_LT(thickness, 2.6) << degrees;
    EXPECT_GT(kept.sheet_count, kept.inside_count * 9 / 10);
  }
}

TEST(PseudoVolume, AFarMajorityLeavesAPocketOpenAndAClosedShapeAlone) {
  // A wavy sheet: the rays' majority fills its valleys, the votes there being little more than half.
  const TriangleSoup wave = test::patch(
      64, 4, [](double u, double v) { return Vec3(u, v, 0.12 * std::sin(4.0 * std::numbers::pi * u)); });
  Progress progress;
  const DistanceField field = make_distance_field(wave, {64, 4}, progress);
  PseudoVolumeOptions options;
  const auto deep_voxels = [&] {
    const PseudoVolume volume = make_pseudo_volume(field, options, progress);
    std::int64_t count = 0;
    for (std::int64_t v = 0; v < field.grid.count(); ++v)
      count += volume.inside[v] != 0 && field.distance[v] > 3.0 * field.grid.spacing;
    return count;
  };
  const std::int64_t filled = deep_voxels();
  EXPECT_GT(filled, 1000);
  options.far_majority = 0.67;
  EXPECT_LT(deep_voxels(), filled / 10);
  const DistanceField ball = make_distance_field(test::sphere(0.5), {64, 4}, progress);
  const auto strict = static_cast<double>(make_pseudo_volume(ball, options, progress).inside_count);
  EXPECT_NEAR(strict / static_cast<double>(made(ball).inside_count), 1.0, 1e-3);
}

TEST(PseudoVolume, TheTailBehindAThinPlateIsOutvoted) {
  // Nowhere deeper than d_subs: a ray changes once and stays inside to the far end; opposite ones differ.
  const Vec3 half(9.0, 9.0, 0.6);
  const DistanceField field =
      test::field_of({30, 30, 20}, [&](const Vec3& x) { return test::box_distance(x, half); });
  const PseudoVolume volume = made(field, Crossing::at_threshold, 6);
  std::int64_t at = 0, behind = 0;
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 30; ++j)
      for (int i = 0; i < 30; ++i, ++at) {
        const Vec3 x = field.grid.center(i, j, k);
        if (std::abs(x.z()) < 4.0 || x.head<2>().cwiseAbs().maxCoeff() > 7.0) continue;
        EXPECT_EQ(volume.votes[at], 1) << "one ray of the six passes the plate before it comes here";
        EXPECT_EQ(volume.inside[at], 0);
        ++behind;
      }
  EXPECT_GT(behind, 0);
}

TEST(PseudoVolume, StopsWhenCancelled) {
  const std::atomic<bool> cancel{true};
  Progress progress({}, &cancel);
  const DistanceField field = test::points_field({30, 30, 30}, 1);
  EXPECT_THROW(make_pseudo_volume(field, {}, progress), Error);
}

/// Rays are cast only where they can change; the same field without a word on its padding is cast whole.
TEST(PseudoVolume, LeavesOutNothingThatHasAMajority) {
  Progress progress;
  const TriangleSoup shapes[] = {test::sphere(0.5), test::torus(0.35, 0.15), test::sheet(1.0, 20.0)};
  for (const TriangleSoup& soup : shapes) {
    const DistanceField padded = make_distance_field(soup, {24, field_padding}, progress);
    DistanceField whole = padded;
    whole.padding = 0;
    for (const Crossing crossing : {Crossing::automatic, Crossing::at_threshold})
      for (const int rays : {6, 14, 26})
        for (const double p_in : {0.87, 3.0, 16.0}) {
          PseudoVolumeOptions options;
          options.p_in_voxels = p_in, options.rays = rays, options.crossing = crossing;
          const PseudoVolume volume = make_pseudo_volume(padded, options, progress);
          const PseudoVolume all = make_pseudo_volume(whole, options, progress);
          ASSERT_EQ(volume.inside, all.inside) << rays << " rays, p_in_voxels " << p_in;
          EXPECT_EQ(volume.sheet_count, all.sheet_count);
          for (std::size_t i = 0; i < all.votes.size(); ++i)
            ASSERT_TRUE(volume.votes[i] == 0 || volume.votes[i] == all.votes[i]);
        }
  }
}

}  // namespace
}  // namespace isochor
