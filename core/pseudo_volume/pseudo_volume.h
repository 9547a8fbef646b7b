#pragma once
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/common/huge_vector.h"
#include "core/common/progress.h"
#include "core/distance_field/distance_field.h"
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// Where a detected crossing takes effect.
enum class Crossing {
  automatic,     ///< at_maximum, plus the at_threshold voxels that have no at_maximum voxel near
  at_maximum,    ///< at the maximum of P that follows the detection
  at_threshold,  ///< at the detecting voxel, the paper's letter
};

struct PseudoVolumeOptions {
  double p_in_voxels = 1.0;      ///< d_in: distance, in voxels, below which P > P_in; 0.87 to 16
  double p_subs_voxels = 1.5;    ///< d_subs ≥ d_in: a further crossing counts only beyond it; to 24
  std::optional<double> p_in;    ///< the same as a probability, no more than 16 voxels; overrides p_in_voxels
  std::optional<double> p_subs;  ///< overrides p_subs_voxels
  int rays = 26;                 ///< 6, 14 or 26 directions
  Crossing crossing = Crossing::automatic;
  /// Share of the votes that a voxel farther than d_in from the surface needs; 0.5 to 0.9. Deep inside a
  /// closed input they are all but unanimous, in the pockets of a sheet or between leaves little more than
  /// half.
  double far_majority = 0.5;
  /// What a watertight input encloses is inside, and elsewhere two thirds of the votes are needed: parts that
  /// overlap become one, and rays that graze small parts fill nothing. Off: the paper's vote alone.
  bool enclosed = true;
  bool operator==(const PseudoVolumeOptions&) const = default;
};

/// Both forms of the thresholds: P = 1 − voxels·spacing/max_distance.
struct Thresholds {
  double p_in_voxels, p_subs_voxels;  ///< d in voxels
  double p_in, p_subs;                ///< probabilities
  double d_in, d_subs;                ///< model units
};
/// Throws invalid_argument for what is out of range.
Thresholds resolve_thresholds(const DistanceField& field, const PseudoVolumeOptions& options);

/// Padding that keeps rays outside and armed at the start. They may change nearer than d_in only; d_subs says
/// when they may change again.
inline int padding_of_rays(double p_in_voxels) {
  return static_cast<int>(std::ceil(p_in_voxels)) + 2;
}
/// That of the largest d_in, so that moving a threshold never makes the distances stale.
inline constexpr double most_p_in_voxels = 16.0;
inline constexpr int field_padding = static_cast<int>(most_p_in_voxels) + 2;

struct PseudoVolume {
  Grid grid;                        ///< that of the distance field
  HugeVector<std::uint8_t> votes;   ///< directions that vote inside, a byte a voxel; 0 far outside
  HugeVector<std::uint8_t> inside;  ///< 1 where enough vote inside, or the input encloses it
  int rays = 0;
  Thresholds thresholds{};
  std::int64_t inside_count = 0;
  std::int64_t sheet_count = 0;  ///< of these, added by Crossing::automatic from at_threshold
};

/// enclosed: of a watertight input, see enclosed_voxels; null: of others. Never fails on a valid field; an
/// empty result is the caller's to judge.
PseudoVolume make_pseudo_volume(const DistanceField& field, const PseudoVolumeOptions& options,
                                Progress& progress, const BitVolume* enclosed = nullptr);

}  // namespace isochor
