#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// The up to eight kept cells around a lattice node, as a mask: bit b is the cell on the side where x is
/// higher if b & 1, y if b & 2, z if b & 4. A cell whose corner c is the node is bit c ^ 7.
std::uint8_t node_mask(const Grid& grid, const std::vector<std::uint8_t>& kept, int i, int j, int k);

/// Cells of a mask grouped by the faces that they share; the label of an absent cell is 0.
struct NodeLink {
  std::array<std::uint8_t, 8> label{};
  int count = 0;
};
const NodeLink& node_link(std::uint8_t mask);

}  // namespace isochor
