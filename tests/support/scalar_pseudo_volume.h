#pragma once
#include <vector>

#include "core/pseudo_volume/directions.h"
#include "core/pseudo_volume/pseudo_volume.h"

namespace isochor::test {

/// The rule written down ray by ray and voxel by voxel, in terms of P. What the bit-sliced sweeps must equal.
class ScalarPseudoVolume {
 public:
  ScalarPseudoVolume(const DistanceField& field, const PseudoVolumeOptions& options)
      : field_(field), options_(options), thresholds_(resolve_thresholds(field, options)) {
    threshold_votes_.resize(field.grid.count()), maximum_votes_.resize(field.grid.count());
    visits_.resize(field.grid.count());
    for (const Vec3i& v : ray_directions().first(options.rays)) cast_all(v);
  }

  /// Votes of the chosen rule.
  std::vector<std::uint8_t> votes() const {
    if (options_.crossing == Crossing::at_threshold) return threshold_votes_;
    if (options_.crossing == Crossing::at_maximum) return maximum_votes_;
    std::vector<std::uint8_t> votes = maximum_votes_;
    const Grid& g = field_.grid;
    for (int k = 0; k < g.size.z(); ++k)
      for (int j = 0; j < g.size.y(); ++j)
        for (int i = 0; i < g.size.x(); ++i) {
          const std::int64_t x = g.index(i, j, k);
          if (is_inside(threshold_votes_[x]) && !solid_near({i, j, k})) votes[x] = threshold_votes_[x];
        }
    return votes;
  }
  bool is_inside(std::uint8_t votes) const { return 2 * votes > options_.rays; }
  const std::vector<std::uint8_t>& visits() const { return visits_; }

 private:
  // P > P_in and P < P_subs as comparisons of float distances, as the field stores them.
  bool above_in(float d) const { return d < static_cast<float>(thresholds_.d_in); }
  bool below_subs(float d) const { return d > static_cast<float>(thresholds_.d_subs); }

  void cast_all(const Vec3i& v) {
    const Grid& g = field_.grid;
    for (int k = 0; k < g.size.z(); ++k)
      for (int j = 0; j < g.size.y(); ++j)
        for (int i = 0; i < g.size.x(); ++i)
          if (!g.contains(i - v[0], j - v[1], k - v[2])) cast({i, j, k}, v);
  }

  void cast(Vec3i x, const Vec3i& v) {
    const Grid& g = field_.grid;
    bool armed = true, pending = false, at_threshold = false, at_maximum = false;
    for (; g.contains(x[0], x[1], x[2]); x += v) {
      const std::int64_t i = g.index(x[0], x[1], x[2]);
      ++visits_[i];
      bool voted = at_maximum;
      const bool interior = (x.array() > 0).all() && (x.array() < g.size.array() - 1).all();
      if (interior) {
        const std::int64_t step = g.index(v[0], v[1], v[2]);
        const float d = field_.distance[i], previous = field_.distance[i - step],
                    next = field_.distance[i + step];
        const bool rises = d<previous, falls = d> previous;
        if (armed && above_in(d) && rises) {
          armed = false, pending = true;
          at_threshold = !at_threshold;
        } else if (!armed && below_subs(d) && falls) {
          armed = true;
        }
        if (pending && d <= previous && d < next) {
          pending = false;
          at_maximum = !at_maximum;
          if (next > previous) voted = at_maximum;
        }
      }
      threshold_votes_[i] += at_threshold;
      maximum_votes_[i] += voted;
    }
  }

  bool solid_near(const Vec3i& x) const {
    const double radius = thresholds_.p_in_voxels + 1.0;
    const int r = static_cast<int>(radius);
    for (int c = -r; c <= r; ++c)
      for (int b = -r; b <= r; ++b)
        for (int a = -r; a <= r; ++a)
          if (a * a + b * b + c * c <= radius * radius &&
              field_.grid.contains(x[0] + a, x[1] + b, x[2] + c) &&
              is_inside(maximum_votes_[field_.grid.index(x[0] + a, x[1] + b, x[2] + c)]))
            return true;
    return false;
  }

  const DistanceField& field_;
  PseudoVolumeOptions options_;
  Thresholds thresholds_;
  std::vector<std::uint8_t> threshold_votes_, maximum_votes_, visits_;
};

}  // namespace isochor::test
