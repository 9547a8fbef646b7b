#include "core/pseudo_volume/pseudo_volume.h"

#include <algorithm>
#include <cmath>

#include "core/pseudo_volume/directions.h"

namespace isochor {
namespace {

/// What a ray remembers from voxel to voxel.
struct RayState {
  bool armed = true, pending = false, at_threshold = false, at_maximum = false;
};

struct Sweep {
  const DistanceField& field;
  float d_in, d_subs;
  std::vector<std::uint8_t> votes_threshold, votes_maximum;

  void cast(Vec3i x, const Vec3i& v) {
    const Grid& g = field.grid;
    RayState ray;
    for (; g.contains(x[0], x[1], x[2]); x += v) {
      const std::int64_t i = g.index(x[0], x[1], x[2]);
      const bool interior = (x.array() > 0).all() && (x.array() < g.size.array() - 1).all();
      const float d = field.distance[i];
      bool voted = ray.at_maximum;
      if (interior && d < d_in) {
        const std::int64_t step = g.index(v[0], v[1], v[2]);
        const float previous = field.distance[i - step], next = field.distance[i + step];
        if (ray.armed && previous > d) ray.armed = false, ray.pending = true, ray.at_threshold ^= true;
        voted = ray.at_maximum;
        if (ray.pending && previous >= d && next > d) {
          ray.pending = false, ray.at_maximum ^= true;
          if (next > previous) voted = ray.at_maximum;
        }
      } else if (d > d_subs) {
        ray.armed = true;
      }
      votes_threshold[i] += ray.at_threshold;
      votes_maximum[i] += voted;
    }
  }

  void run(const Vec3i& v) {
    const Grid& g = field.grid;
    for (int k = 0; k < g.size.z(); ++k)
      for (int j = 0; j < g.size.y(); ++j)
        for (int i = 0; i < g.size.x(); ++i)
          if (!g.contains(i - v[0], j - v[1], k - v[2])) cast({i, j, k}, v);
  }
};

/// True where a voxel of `set` lies within radius voxels.
bool near_set(const Grid& g, const std::vector<std::uint8_t>& set, const Vec3i& x, double radius) {
  const int r = static_cast<int>(radius);
  for (int c = -r; c <= r; ++c)
    for (int b = -r; b <= r; ++b)
      for (int a = -r; a <= r; ++a)
        if (a * a + b * b + c * c <= radius * radius && g.contains(x[0] + a, x[1] + b, x[2] + c) &&
            set[g.index(x[0] + a, x[1] + b, x[2] + c)])
          return true;
  return false;
}

}  // namespace

PseudoVolume make_pseudo_volume(const DistanceField& field, const PseudoVolumeOptions& options,
                                Progress& progress) {
  PseudoVolume volume;
  volume.grid = field.grid;
  volume.rays = options.rays;
  volume.thresholds = resolve_thresholds(field, options);
  const std::int64_t n = field.grid.count();
  Sweep sweep{field, static_cast<float>(volume.thresholds.d_in), static_cast<float>(volume.thresholds.d_subs),
              std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n)};
  for (int r = 0; r < options.rays; ++r) {
    progress.throw_if_cancelled();
    progress.report("pseudo_volume", static_cast<double>(r) / options.rays);
    sweep.run(ray_directions()[r]);
  }
  const bool threshold = options.crossing == Crossing::at_threshold;
  volume.votes = threshold ? sweep.votes_threshold : sweep.votes_maximum;
  volume.inside.resize(n);
  for (std::int64_t i = 0; i < n; ++i) volume.inside[i] = 2 * volume.votes[i] > options.rays;
  if (options.crossing == Crossing::automatic) {
    const std::vector<std::uint8_t> at_maximum = volume.inside;
    const double radius = volume.thresholds.p_in_voxels + 1.0;
    std::int64_t i = 0;
    for (int c = 0; c < field.grid.size.z(); ++c)
      for (int b = 0; b < field.grid.size.y(); ++b)
        for (int a = 0; a < field.grid.size.x(); ++a, ++i)
          if (2 * sweep.votes_threshold[i] > options.rays && !at_maximum[i] &&
              !near_set(field.grid, at_maximum, {a, b, c}, radius))
            volume.inside[i] = 1, volume.votes[i] = sweep.votes_threshold[i];
  }
  volume.inside_count = std::count(volume.inside.begin(), volume.inside.end(), 1);
  return volume;
}

}  // namespace isochor
