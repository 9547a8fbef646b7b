#include "core/pseudo_volume/votes.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isochor {
namespace {

/// Eight bits spread to eight bytes, the lowest bit first in memory.
constexpr std::array<std::array<std::uint8_t, 8>, 256> spread_table = [] {
  std::array<std::array<std::uint8_t, 8>, 256> table{};
  for (int value = 0; value < 256; ++value)
    for (int bit = 0; bit < 8; ++bit) table[value][bit] = static_cast<std::uint8_t>(value >> bit & 1);
  return table;
}();

std::uint64_t spread(std::uint64_t bits) {
  std::uint64_t bytes;
  std::memcpy(&bytes, spread_table[bits & 0xFF].data(), 8);
  return bytes;
}

/// Calls write(group, bytes) for the groups of 8 voxels of a word; make(shift) gives the 8 bytes.
template <class Make>
void write_word(int voxels, std::uint8_t* out, Make&& make) {
  for (int i = 0; i < voxels; i += 8) {
    const std::uint64_t bytes = make(i);
    std::memcpy(out + i, &bytes, std::min(8, voxels - i));
  }
}

}  // namespace

void Votes::unpack_row(int j, int k, std::uint8_t* bytes) const {
  const std::int64_t first = words_ * (j + std::int64_t{size_.y()} * k);
  for (int w = 0; w < words_; ++w) {
    const std::uint64_t* count = counts_.data() + planes * (first + w);
    const int voxels = std::min(64, size_.x() - 64 * w);
    if ((count[0] | count[1] | count[2] | count[3] | count[4]) == 0) {
      std::memset(bytes + 64 * w, 0, voxels);
      continue;
    }
    write_word(voxels, bytes + 64 * w, [&](int shift) {
      std::uint64_t sum = 0;
      for (int p = 0; p < planes; ++p) sum += spread(count[p] >> shift) << p;
      return sum;
    });
  }
}

void unpack_row(const BitVolume& volume, int j, int k, std::uint8_t* bytes) {
  const std::uint64_t* row = volume.row(j, k);
  for (int w = 0; w < volume.words; ++w)
    write_word(std::min(64, volume.size.x() - 64 * w), bytes + 64 * w,
               [&](int shift) { return spread(row[w] >> shift); });
}

}  // namespace isochor
