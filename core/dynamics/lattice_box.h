#pragma once
#include <algorithm>
#include <array>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// The smallest box of lattice cells that holds those of a body.
struct LatticeBox {
  std::array<int, 3> low, size;  ///< cells

  explicit LatticeBox(const TetMesh& mesh) : low(mesh.cells.front().coord) {
    std::array<int, 3> high = low;
    for (const Cell& cell : mesh.cells)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], cell.coord[axis]);
        high[axis] = std::max(high[axis], cell.coord[axis]);
      }
    for (int axis = 0; axis < 3; ++axis) size[axis] = high[axis] - low[axis] + 1;
  }
  std::int64_t cells() const { return std::int64_t{size[0]} * size[1] * size[2]; }
};

inline bool fills_its_box(const TetMesh& mesh) {
  return static_cast<std::int64_t>(mesh.cells.size()) == LatticeBox(mesh).cells();
}

}  // namespace isochor
