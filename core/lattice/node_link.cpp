#include "core/lattice/node_link.h"

#include <algorithm>

namespace isochor {
namespace {

void spread(std::uint8_t mask, int cell, std::uint8_t label, std::uint8_t& visited, NodeLink& link) {
  if ((mask >> cell & 1) == 0 || (visited >> cell & 1) != 0) return;
  visited = static_cast<std::uint8_t>(visited | 1 << cell);
  link.label[cell] = label;
  for (const int axis : {1, 2, 4}) spread(mask, cell ^ axis, label, visited, link);
}

NodeLink make_link(std::uint8_t mask) {
  NodeLink link;
  std::uint8_t visited = 0;
  for (int cell = 0; cell < 8; ++cell) {
    if ((mask >> cell & 1) == 0 || (visited >> cell & 1) != 0) continue;
    spread(mask, cell, static_cast<std::uint8_t>(link.count++), visited, link);
  }
  return link;
}

}  // namespace

std::uint8_t node_mask(const Grid& grid, const std::vector<std::uint8_t>& kept, int i, int j, int k) {
  unsigned mask = 0;
  for (int b = 0; b < 8; ++b) {
    const int x = i - 1 + (b & 1), y = j - 1 + (b >> 1 & 1), z = k - 1 + (b >> 2 & 1);
    if (grid.contains(x, y, z) && kept[grid.index(x, y, z)] != 0) mask |= 1U << b;
  }
  return static_cast<std::uint8_t>(mask);
}

const NodeLink& node_link(std::uint8_t mask) {
  static const std::array<NodeLink, 256> table = [] {
    std::array<NodeLink, 256> links;
    for (int m = 0; m < 256; ++m) links[m] = make_link(static_cast<std::uint8_t>(m));
    return links;
  }();
  return table[mask];
}

}  // namespace isochor
