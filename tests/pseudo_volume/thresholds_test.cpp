#include <gtest/gtest.h>

#include "core/pseudo_volume/pseudo_volume.h"
#include "tests/support/fields.h"

namespace isochor {
namespace {

DistanceField plain_field() {
  DistanceField field = test::field_of({8, 8, 8}, [](const Vec3& x) { return x.norm(); });
  field.grid.spacing = 0.25;
  field.max_distance = 5.0F;
  return field;
}

TEST(Thresholds, AreTheSameInBothForms) {
  const DistanceField field = plain_field();
  PseudoVolumeOptions options;
  options.p_in_voxels = 2.0, options.p_subs_voxels = 3.0;
  const Thresholds t = resolve_thresholds(field, options);
  EXPECT_DOUBLE_EQ(t.d_in, 0.5);
  EXPECT_DOUBLE_EQ(t.p_in, 0.9);
  EXPECT_DOUBLE_EQ(t.p_subs, 0.85);
  PseudoVolumeOptions back;
  back.p_in = t.p_in, back.p_subs = t.p_subs;
  EXPECT_NEAR(resolve_thresholds(field, back).p_in_voxels, 2.0, 1e-12);
  EXPECT_NEAR(resolve_thresholds(field, back).p_subs_voxels, 3.0, 1e-12);
}

TEST(Thresholds, SubsIsNeverNearerThanIn) {
  PseudoVolumeOptions options;
  options.p_in_voxels = 4.0, options.p_subs_voxels = 1.5;
  EXPECT_DOUBLE_EQ(resolve_thresholds(plain_field(), options).p_subs_voxels, 4.0);
}

TEST(Thresholds, PaddingLeavesRoomToStartOutside) {
  for (double p_in = 0.1; p_in <= most_p_in_voxels; p_in += 0.1) {
    EXPECT_GT(padding_of_rays(p_in) - 0.5, p_in);  // the outermost centres are not near
    EXPECT_LE(padding_of_rays(p_in), field_padding);
  }
}

TEST(Thresholds, RefuseWhatCannotBe) {
  const auto refused = [](auto&& change) {
    PseudoVolumeOptions options;
    change(options);
    try {
      resolve_thresholds(plain_field(), options);
    } catch (const Error& error) {
      return error.code() == ErrorCode::invalid_argument && !error.details().empty();
    }
    return false;
  };
  EXPECT_TRUE(refused([](auto& o) { o.rays = 7; }));
  EXPECT_TRUE(refused([](auto& o) { o.p_in_voxels = 17.0; }));
  EXPECT_TRUE(refused([](auto& o) { o.p_in_voxels = std::nan(""); }));
  EXPECT_TRUE(refused([](auto& o) { o.p_subs_voxels = -1.0; }));
  EXPECT_TRUE(refused([](auto& o) { o.p_in = 1.5; }));
  EXPECT_FALSE(refused([](auto&) {}));
}

TEST(Thresholds, BeyondTheLargestReachTheSmallestProbabilityIsNamed) {
  PseudoVolumeOptions options;
  options.p_in = 0.5, options.p_subs = 0.4;
  DistanceField field = plain_field();
  field.max_distance = 20.0F;
  try {
    resolve_thresholds(field, options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.details().at(0).pointer, "/p_in");
    EXPECT_NEAR(error.details().at(0).min.value(), 1.0 - 16.0 * 0.25 / 20.0, 1e-12);
  }
  options.p_in = 0.8;
  EXPECT_DOUBLE_EQ(resolve_thresholds(field, options).p_subs, 0.4);
}

}  // namespace
}  // namespace isochor
