#pragma once
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// A counter from 0 to 31 a voxel, bit-sliced: five words hold the counters of 64 voxels.
class Votes {
 public:
  static constexpr int planes = 5;

  Votes() = default;
  explicit Votes(const BitVolume& shape)
      : size_(shape.size), words_(shape.words), counts_(planes * shape.bits.size(), 0) {}

  /// Adds a, b and c, 64 votes each, to the voxels of word `at` (row · words + w).
  void add(std::int64_t at, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    std::uint64_t* count = counts_.data() + planes * at;
    const std::uint64_t ones = a ^ b ^ c, twos = (a & b) | (c & (a ^ b));
    std::uint64_t carry = count[0] & ones;
    count[0] ^= ones;
    const std::uint64_t half = count[1] ^ twos;
    const std::uint64_t fours = (count[1] & twos) | (half & carry);
    count[1] = half ^ carry;
    carry = fours;
    for (int p = 2; p < planes; ++p) {
      const std::uint64_t next = count[p] & carry;
      count[p] ^= carry;
      carry = next;
    }
  }

  /// Bits of the voxels of word `at` with more votes than `limit`.
  std::uint64_t above(std::int64_t at, int limit) const {
    const std::uint64_t* count = counts_.data() + planes * at;
    std::uint64_t more = 0, equal = ~std::uint64_t{0};
    for (int p = planes - 1; p >= 0; --p) {
      if (limit >> p & 1) {
        equal &= count[p];
      } else {
        more |= equal & count[p];
        equal &= ~count[p];
      }
    }
    return more;
  }

  /// Takes over the counters of `other` where `mask` is set.
  void replace(std::int64_t at, std::uint64_t mask, const Votes& other) {
    for (std::int64_t i = planes * at; i < planes * (at + 1); ++i)
      counts_[i] = (counts_[i] & ~mask) | (other.counts_[i] & mask);
  }

  /// Writes the counters of a row as bytes.
  void unpack_row(int j, int k, std::uint8_t* bytes) const;

 private:
  Vec3i size_ = Vec3i::Zero();
  int words_ = 0;
  std::vector<std::uint64_t> counts_;
};

/// Writes the bits of a row as bytes 0 or 1.
void unpack_row(const BitVolume& volume, int j, int k, std::uint8_t* bytes);

}  // namespace isochor
