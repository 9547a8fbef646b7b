#pragma once
#include "core/distance_field/distance_field.h"
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// The part of a field in which rays can change, with a rim of one voxel or more that is not near. What lies
/// outside of it is beyond a face of the soup's box: rays that come from there do not change before, and of
/// those that leave through there are fewer than half, so that it needs no votes.
struct FieldWindow {
  FieldWindow(const DistanceField& whole, double d_in);
  std::int64_t index(int i, int j, int k) const {
    return field.grid.index(i + margin, j + margin, k + margin);
  }

  const DistanceField& field;
  int margin;  ///< voxels of the field left out on each side
  Vec3i size;
};

/// What the rays' rule asks of a voxel: P > P_in, that is d < d_in, and P < P_subs, that is d > d_subs. The
/// outermost voxels are never near, so that a near voxel has neighbours in all directions.
struct VoxelMasks {
  BitVolume near, far;
};
VoxelMasks make_voxel_masks(const FieldWindow& window, double d_in, double d_subs);

/// Bit i: a[i] > b[i], of 64 values.
inline std::uint64_t greater(const float* a, const float* b) {
  alignas(64) std::uint8_t bytes[64];
  for (int i = 0; i < 64; ++i) bytes[i] = a[i] > b[i];
  std::uint64_t mask = 0;
  for (int group = 0; group < 8; ++group) {
    std::uint64_t ones;  // eight bytes of 0 or 1, gathered into eight bits by one multiplication
    __builtin_memcpy(&ones, bytes + 8 * group, 8);
    mask |= (ones * 0x0102040810204080U >> 56) << 8 * group;
  }
  return mask;
}

/// 64 distances from an index on, which may begin before or end after the field; what lies outside is
/// unspecified.
class DistanceWindow {
 public:
  DistanceWindow(const DistanceField& field, std::int64_t first) {
    const auto count = static_cast<std::int64_t>(field.distance.size());
    data_ = field.distance.data() + first;
    if (first >= 0 && first + 64 <= count) return;
    for (std::int64_t i = 0; i < 64; ++i)
      copy_[i] = first + i >= 0 && first + i < count ? field.distance[first + i] : 0.0F;
    data_ = copy_;
  }
  DistanceWindow(const DistanceWindow&) = delete;
  DistanceWindow& operator=(const DistanceWindow&) = delete;
  operator const float*() const { return data_; }

 private:
  const float* data_;
  float copy_[64];
};

}  // namespace isochor
