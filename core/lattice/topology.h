#pragma once
#include <cstdint>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// Sets of cells as a byte a cell of the grid. All functions are free of any order, so that a symmetric set
/// stays symmetric.
using CellSet = std::vector<std::uint8_t>;

/// Adds cells with more than three of their six face neighbours in the set, until nothing changes
/// [Diziol 2009, section 3].
void fill_holes(const Grid& grid, CellSet& kept);

/// Face-connected components, numbered in lattice order.
struct Components {
  std::vector<std::int32_t> label;  ///< a cell; -1 outside the set
  std::vector<std::int64_t> size;
};
Components label_components(const Grid& grid, const CellSet& kept);

/// Keeps the component with most cells, the first in lattice order among equals.
void keep_largest(const Components& components, CellSet& kept);

/// Hinges: lattice edges where two diagonal cells of the four meet, nodes where two antipodal cells of the
/// eight meet, and none of the others is kept.
struct ContactCounts {
  std::int64_t edges = 0, nodes = 0;
};
ContactCounts count_contacts(const Grid& grid, const CellSet& kept);

/// Adds the other cells around each contact, once; returns how many contacts there were.
std::int64_t fill_contacts(const Grid& grid, CellSet& kept);

}  // namespace isochor
