#include "core/pipeline/shortfall.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/common/error.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using testing::HasSubstr;

MeshingOptions settings(int voxels, int cells, double p_in_voxels = 1.0) {
  MeshingOptions options;
  options.voxels = voxels;
  options.lattice.cells = cells;
  options.pseudo_volume.p_in_voxels = p_in_voxels;
  options.pseudo_volume.p_subs_voxels = std::max(1.5, p_in_voxels);
  return options;
}

std::shared_ptr<const Model> make(TriangleSoup soup, const MeshingOptions& options) {
  Progress progress;
  return AuthoringPipeline(std::make_shared<const TriangleSoup>(std::move(soup))).run(options, progress);
}

Error failure(TriangleSoup soup, const MeshingOptions& options) {
  try {
    make(std::move(soup), options);
  } catch (const Error& error) {
    return error;
  }
  return {ErrorCode::internal, "nothing was thrown"};
}

/// Two triangles that are tiny for the distance between them.
TriangleSoup strays() {
  TriangleSoup soup{{{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}}, {{0, 1, 2}}};
  test::append(soup, {{{900, 900, 900}, {901e-3 + 900, 900, 900}, {900, 900.001, 900}}, {{0, 1, 2}}});
  return soup;
}

TEST(Shortfall, ASolidAndASheetAreComplete) {
  EXPECT_FALSE(shortfall(*make(test::sphere(0.5, 1.0, 32), settings(48, 12))));
  EXPECT_FALSE(shortfall(*make(test::sheet(1.0), settings(48, 12, 4.0))));
}

// Thresholds that keep the point of a solid spike thicken all of it.
TEST(Shortfall, TheThinEndOfASolidAsksForMoreCells) {
  const TriangleSoup spike{{{-0.5, -0.5, 0}, {-0.5, 0.5, 0}, {1, 0, 0}, {0, 0, 4}},
                           {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}}};
  const auto blunt = make(spike, settings(128, 24));
  ASSERT_TRUE(shortfall(*blunt));
  EXPECT_EQ(shortfall(*blunt)->hint, "try 48 cells");
  ASSERT_EQ(blunt->fixes.size(), 1U);
  EXPECT_EQ(blunt->fixes[0].parameter, "cells");
  EXPECT_EQ(blunt->fixes[0].value, 48.0);
  EXPECT_FALSE(shortfall(*make(spike, settings(128, 48))));
  EXPECT_EQ(coverage_advice(*make(spike, settings(60, 24))), "try 48 cells and 96 voxels");
}

TEST(Shortfall, ADoubleWallOfOneSenseIsSolidAndOneOfOppositeSensesHollow) {
  const TriangleSoup outer = test::sphere(0.5, 1.0, 48);
  TriangleSoup inner = test::sphere(0.499, 1.0, 48), solid = outer, hollow = outer;
  test::append(solid, inner);
  for (Triangle& t : inner.triangles) std::swap(t[0], t[1]);
  test::append(hollow, inner);
  EXPECT_FALSE(shortfall(*make(solid, settings(48, 12))));
  const auto filled = make(hollow, settings(48, 12));
  ASSERT_TRUE(shortfall(*filled));
  EXPECT_THAT(shortfall(*filled)->what, HasSubstr("the closed input encloses 0.00"));
  EXPECT_THAT(shortfall(*filled)->hint, HasSubstr("walls are about 0.00"));
}

TEST(Shortfall, CellsAroundStrayTrianglesAreNoModelOfThem) {
  const auto blobs = make(strays(), settings(48, 12, 6.0));
  EXPECT_GT(blobs->quality.coverage, 0.99);
  ASSERT_TRUE(shortfall(*blobs));
  EXPECT_THAT(shortfall(*blobs)->what, HasSubstr("the box of its input, two cells thicker, holds"));
  EXPECT_THAT(blobs->warnings.back(), HasSubstr("the model is incomplete"));
  // What was tried and gives no model is not advised.
  const Error empty = failure(strays(), settings(48, 12));
  EXPECT_EQ(empty.code(), ErrorCode::empty_result);
  EXPECT_THAT(empty.hint(), HasSubstr("stray parts"));
}

TEST(Shortfall, ALooseCrownMayFillAllOfItsBox) {
  TriangleSoup leaves = test::sphere(0.5, 1.0, 48);
  for (std::size_t t = 0; t < leaves.triangles.size() / 12; ++t)
    leaves.triangles[t] = leaves.triangles[12 * t];
  leaves.triangles.resize(leaves.triangles.size() / 12);
  const auto crown = make(leaves, settings(64, 16, 4.0));
  EXPECT_GT(crown->quality.volume, 0.3);  // a twelfth of the sphere's surface closes it
  EXPECT_FALSE(shortfall(*crown)) << shortfall(*crown)->what;
}

TEST(Shortfall, AClosedPlateLearnsHowManyCellsItsWallsNeed) {
  const TriangleSoup plate = test::box({0, 0, 0}, {1, 1, 0.04});
  const Error thin = failure(plate, settings(64, 12));
  EXPECT_THAT(thin.hint(), HasSubstr("thick, so try 54 cells and 108 voxels"));
  EXPECT_FALSE(shortfall(*make(plate, settings(108, 54))));
  EXPECT_THAT(failure(test::box({0, 0, 0}, {1, 1, 0.001}), settings(64, 12)).hint(),
              HasSubstr("thicken the walls"));
}

TEST(Shortfall, APlateThinnerThanAllCellsLearnsWhatMakesABodyAsThickAsThem) {
  const TriangleSoup plate = test::box({0, 0, 0}, {100, 0.4, 60});
  MeshingOptions options = settings(128, 24);
  const std::string hint = failure(plate, options).hint(), words = "or try density ";
  const auto at = hint.find(words);
  ASSERT_NE(at, std::string::npos) << hint;
  options.lattice.density = std::stod(hint.substr(at + words.size()));
  EXPECT_GT(make(plate, options)->lattice->kept_count, 0);
}

TEST(Shortfall, APlateThatItsThresholdsThickenIsNotToldToTakeFewerCells) {
  MeshingOptions thick = settings(108, 54, 4.0);
  thick.lattice.density = 0.2, thick.lattice.fit_volume = false;
  const auto plate = make(test::box({0, 0, 0}, {1, 1, 0.04}), thick);
  ASSERT_TRUE(shortfall(*plate));
  EXPECT_THAT(shortfall(*plate)->hint, HasSubstr("try the preset solid"));
}

TriangleSoup tilted(TriangleSoup soup) {
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.471, Vec3::UnitZ())) * Eigen::AngleAxisd(0.332, Vec3::UnitX());
  for (Vec3& p : soup.positions) p = tilt * p;
  return soup;
}

/// Thinner than a cell and slanted to the lattice: its pieces lie near all of it, with an eighth of the
/// volume lost. What passes through itself is judged alike.
TEST(Shortfall, APlateThatFallsToPiecesIsNoModelOfIt) {
  const TriangleSoup plate = test::box({-0.5, -0.015, -0.5}, {0.5, 0.015, 0.5});
  TriangleSoup crossed = plate;
  test::append(crossed, test::box(Vec3::Constant(-0.02), Vec3::Constant(0.02)));
  for (const TriangleSoup& soup : {tilted(plate), tilted(crossed)}) {
    const auto pieces = make(soup, settings(64, 24));
    EXPECT_TRUE(pieces->input->closed);
    EXPECT_GT(pieces->quality.coverage, 0.99);
    EXPECT_LT(pieces->volume_error(), 0.25);
    ASSERT_TRUE(shortfall(*pieces));
    EXPECT_THAT(shortfall(*pieces)->what, HasSubstr("parts, and its volume is 0.02"));
  }
  EXPECT_FALSE(shortfall(*make(tilted(plate), settings(152, 76))));
}

}  // namespace
}  // namespace isochor
