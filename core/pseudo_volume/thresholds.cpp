#include <algorithm>
#include <array>
#include <cmath>

#include "core/pseudo_volume/pseudo_volume.h"

namespace isochor {
namespace {

void check(const PseudoVolumeOptions& o) {
  const auto refuse = [](const char* pointer, double value, double min, double max) {
    if (value >= min && value <= max) return;
    throw Error(ErrorCode::invalid_argument, std::string(pointer + 1) + " is out of range",
                "see the range in the details", {{pointer, "out of range", min, max}});
  };
  if (o.rays != 6 && o.rays != 14 && o.rays != 26)
    throw Error(ErrorCode::invalid_argument, "rays must be 6, 14 or 26", "use 26",
                {{"/rays", "6, 14 or 26", 6.0, 26.0}});
  refuse("/p_in_voxels", o.p_in_voxels, 0.1, most_p_in_voxels);
  refuse("/p_subs_voxels", o.p_subs_voxels, 0.1, 24.0);
  refuse("/far_majority", o.far_majority, 0.5, 0.9);
  if (o.p_in) refuse("/p_in", *o.p_in, 0.0, 1.0);
  if (o.p_subs) refuse("/p_subs", *o.p_subs, 0.0, 1.0);
}

/// Beyond, rays would have no room to start outside.
void check_reach(const Thresholds& t, double spacing, double max_distance) {
  if (t.p_in_voxels <= most_p_in_voxels * (1.0 + 1e-9)) return;
  throw Error(
      ErrorCode::invalid_argument,
      "p_in reaches " + std::to_string(std::lround(t.p_in_voxels)) +
          " voxels from the surface, and rays then have no room to start outside",
      "use a p_in nearer to 1, or p_in_voxels",
      {{"/p_in", "too far from 1 for this mesh", 1.0 - most_p_in_voxels * spacing / max_distance, 1.0}});
}

}  // namespace

Thresholds resolve_thresholds(const DistanceField& field, const PseudoVolumeOptions& options) {
  check(options);
  const double h = field.grid.spacing;
  const double max_distance = std::max<double>(field.max_distance, 1e-30);
  Thresholds t{};
  t.d_in = options.p_in ? (1.0 - *options.p_in) * max_distance : options.p_in_voxels * h;
  t.d_subs = options.p_subs ? (1.0 - *options.p_subs) * max_distance : options.p_subs_voxels * h;
  t.d_subs = std::max(t.d_subs, t.d_in);
  t.p_in_voxels = t.d_in / h, t.p_subs_voxels = t.d_subs / h;
  t.p_in = 1.0 - t.d_in / max_distance, t.p_subs = 1.0 - t.d_subs / max_distance;
  check_reach(t, h, max_distance);
  return t;
}

}  // namespace isochor
