#include <gtest/gtest.h>

#include <algorithm>

#include "core/parallel/parallel.h"
#include "core/pseudo_volume/proximity.h"
#include "tests/support/fields.h"
#include "tests/support/scalar_pseudo_volume.h"

namespace isochor {
namespace {

void expect_equal(const DistanceField& field, const PseudoVolumeOptions& options) {
  const test::ScalarPseudoVolume reference(field, options);
  Progress progress;
  const PseudoVolume volume = make_pseudo_volume(field, options, progress);
  const std::vector<std::uint8_t> votes = reference.votes();
  ASSERT_TRUE(std::ranges::equal(volume.votes, votes));
  std::int64_t inside = 0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    ASSERT_EQ(volume.inside[i] != 0, reference.is_inside(votes[i]));
    inside += volume.inside[i];
  }
  EXPECT_EQ(volume.inside_count, inside);
}

/// Rule × rays × thresholds × field; widths on both sides of a word's end.
struct Case {
  Crossing crossing;
  int rays;
  double p_in, p_subs;
};
void PrintTo(const Case& c, std::ostream* out) {
  const char* rules[] = {"automatic", "at_maximum", "at_threshold"};
  *out << rules[static_cast<int>(c.crossing)] << ", " << c.rays << " rays, p_in " << c.p_in << ", p_subs "
       << c.p_subs;
}

class SweepAgainstReference : public testing::TestWithParam<Case> {};

TEST_P(SweepAgainstReference, AgreesOnEveryVoxel) {
  const auto [crossing, rays, p_in, p_subs] = GetParam();
  PseudoVolumeOptions options;
  options.crossing = crossing, options.rays = rays;
  options.p_in_voxels = p_in, options.p_subs_voxels = p_subs;
  unsigned seed = 0;
  for (const Vec3i& size :
       {Vec3i(63, 17, 20), Vec3i(64, 20, 17), Vec3i(65, 9, 30), Vec3i(130, 14, 11), Vec3i(7, 40, 9)}) {
    SCOPED_TRACE(testing::Message() << "size " << size.transpose() << ", seed " << seed);
    expect_equal(test::random_field(size, seed), options);
    expect_equal(test::points_field(size, seed), options);
    expect_equal(test::field_of(size, [&](const Vec3& x) { return x.norm() - 0.3 * size.minCoeff(); }),
                 options);
    ++seed;
  }
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Crossing crossing : {Crossing::automatic, Crossing::at_maximum, Crossing::at_threshold})
    for (const int rays : {6, 14, 26})
      for (const auto& [p_in, p_subs] : {std::pair{0.87, 0.87}, {1.0, 1.5}, {2.5, 3.5}})
        all.push_back({crossing, rays, p_in, p_subs});
  return all;
}
INSTANTIATE_TEST_SUITE_P(RulesRaysThresholds, SweepAgainstReference, testing::ValuesIn(cases()));

TEST(Rays, VisitEveryVoxelOnceADirection) {
  const DistanceField field = test::random_field({9, 7, 8}, 1);
  for (const int rays : {6, 14, 26}) {
    PseudoVolumeOptions options;
    options.rays = rays;
    const test::ScalarPseudoVolume reference(field, options);
    EXPECT_TRUE(std::ranges::all_of(reference.visits(), [&](int n) { return n == rays; }));
  }
}

// A ray that never arms again after entering votes inside from there to the end: with a field that is near
// once and then nowhere far, the votes show which voxels each ray of the sweeps visits.
TEST(Rays, SweepsVisitWhatTheReferenceVisits) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    DistanceField field = test::field_of({70, 9, 10}, [](const Vec3&) { return 1.2; });
    std::mt19937 random(seed);
    const auto at = [&](int n) { return 1 + static_cast<int>(random() % (n - 2)); };
    field.distance[field.grid.index(at(70), at(9), at(10))] = 0.5F;
    PseudoVolumeOptions options;
    options.crossing = Crossing::at_threshold;
    expect_equal(field, options);
    Progress progress;
    const PseudoVolume volume = make_pseudo_volume(field, options, progress);
    EXPECT_EQ(*std::ranges::max_element(volume.votes), 26);
  }
}

TEST(RemoveNear, AgreesWithBruteForce) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    std::mt19937 random(seed);
    BitVolume voxels(Vec3i(130, 9, 8)), others(voxels.size);
    const auto scatter = [&](BitVolume& volume, int count) {
      for (int n = 0; n < count; ++n) {
        const int i = static_cast<int>(random() % 130), j = static_cast<int>(random() % 9),
                  k = static_cast<int>(random() % 8);
        volume.row(j, k)[i / 64] |= std::uint64_t{1} << i % 64;
      }
    };
    const auto test = [](const BitVolume& v, int i, int j, int k) {
      return (v.row(j, k)[i / 64] >> i % 64 & 1) != 0;
    };
    scatter(voxels, 600);
    scatter(others, 12);
    const double radius = 1.0 + 2.3 * seed;
    BitVolume result = voxels;
    remove_near(result, others, radius);
    for (int k = 0; k < 8; ++k)
      for (int j = 0; j < 9; ++j)
        for (int i = 0; i < 130; ++i) {
          bool near = false;
          for (int c = 0; c < 8; ++c)
            for (int b = 0; b < 9; ++b)
              for (int a = 0; a < 130; ++a)
                near = near || (test(others, a, b, c) &&
                                (a - i) * (a - i) + (b - j) * (b - j) + (c - k) * (c - k) <= radius * radius);
          ASSERT_EQ(test(result, i, j, k), test(voxels, i, j, k) && !near);
        }
  }
}

TEST(PseudoVolume, GivesTheSameVotesForAnyNumberOfThreads) {
  const DistanceField field = test::points_field({70, 30, 40}, 9);
  Progress progress;
  set_thread_count(1);
  const PseudoVolume one = make_pseudo_volume(field, {}, progress);
  set_thread_count(3);
  const PseudoVolume three = make_pseudo_volume(field, {}, progress);
  set_thread_count(0);
  EXPECT_EQ(one.votes, three.votes);
}

}  // namespace
}  // namespace isochor
