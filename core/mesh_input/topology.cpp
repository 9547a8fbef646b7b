#include "core/mesh_input/topology.h"

#include <bit>

namespace isochor {
namespace {

std::uint64_t hash(const Vec3& p) {
  std::uint64_t h = 0;
  for (int axis = 0; axis < 3; ++axis) {
    h ^= std::bit_cast<std::uint64_t>(p[axis] + 0.0);  // −0 + 0 = 0
    h *= 0x9e3779b97f4a7c15U;                          // Fibonacci hashing [Knuth, vol. 3, 6.4]
    h ^= h >> 29;
  }
  return h;
}

}  // namespace

std::vector<std::int32_t> merge_vertices(const std::vector<Vec3>& positions) {
  std::vector<std::int32_t> first(positions.size());
  const std::size_t slots = std::bit_ceil(2 * positions.size() + 1);
  std::vector<std::int32_t> table(slots, -1);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    std::size_t slot = hash(positions[v]) & (slots - 1);
    while (table[slot] >= 0 && positions[table[slot]] != positions[v]) slot = (slot + 1) & (slots - 1);
    if (table[slot] < 0) table[slot] = static_cast<std::int32_t>(v);
    first[v] = table[slot];
  }
  return first;
}

}  // namespace isochor
