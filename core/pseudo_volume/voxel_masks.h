#pragma once
#ifdef __SSE2__
#include <emmintrin.h>
#endif
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
#ifdef __SSE2__
inline std::uint64_t greater(const float* a, const float* b) {
  const auto four = [&](int i) {
    return _mm_castps_si128(_mm_cmpgt_ps(_mm_loadu_ps(a + i), _mm_loadu_ps(b + i)));
  };
  const auto sixteen = [&](int i) {
    const __m128i low = _mm_packs_epi32(four(i), four(i + 4)),
                  high = _mm_packs_epi32(four(i + 8), four(i + 12));
    return std::uint64_t{static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(low, high)))};
  };
  return sixteen(0) | sixteen(16) << 16 | sixteen(32) << 32 | sixteen(48) << 48;
}
#else
inline std::uint64_t greater(const float* a, const float* b) {
  std::uint64_t mask = 0;
  for (int i = 0; i < 64; ++i) mask |= std::uint64_t{a[i] > b[i]} << i;
  return mask;
}
#endif

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
