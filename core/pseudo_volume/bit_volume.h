#pragma once
#include <bit>
#include <cstdint>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// One bit a voxel, 64 voxels of a row (along x) in a word. Bits past the end of a row carry no meaning.
struct BitVolume {
  Vec3i size = Vec3i::Zero();
  int words = 0;  ///< a row
  std::vector<std::uint64_t> bits;

  BitVolume() = default;
  explicit BitVolume(const Vec3i& voxels)
      : size(voxels), words((voxels.x() + 63) / 64), bits(std::size_t(words) * voxels.y() * voxels.z(), 0) {}

  std::int64_t row_index(int j, int k) const { return j + std::int64_t{size.y()} * k; }
  std::int64_t rows() const { return std::int64_t{size.y()} * size.z(); }
  std::uint64_t* row(int j, int k) { return bits.data() + words * row_index(j, k); }
  const std::uint64_t* row(int j, int k) const { return bits.data() + words * row_index(j, k); }

  /// Of all bits; those past the ends of rows have to be zero.
  std::int64_t count() const {
    std::int64_t sum = 0;
    for (const std::uint64_t word : bits) sum += std::popcount(word);
    return sum;
  }

  /// The bits of word w that lie within the row.
  std::uint64_t valid(int w) const {
    const int left = size.x() - 64 * w;
    return left >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << left) - 1;
  }
};

}  // namespace isochor
