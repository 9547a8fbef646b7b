#include "core/lattice/topology.h"

#include <algorithm>

namespace isochor {
namespace {

/// Calls visit(index) for the face neighbours of a cell that lie in the grid.
template <class Visit>
void for_face_neighbors(const Grid& grid, std::int64_t cell, Visit&& visit) {
  const std::int64_t nx = grid.size.x(), ny = grid.size.y(), nz = grid.size.z();
  const std::int64_t i = cell % nx, j = cell / nx % ny, k = cell / (nx * ny);
  if (i > 0) visit(cell - 1);
  if (i + 1 < nx) visit(cell + 1);
  if (j > 0) visit(cell - nx);
  if (j + 1 < ny) visit(cell + nx);
  if (k > 0) visit(cell - nx * ny);
  if (k + 1 < nz) visit(cell + nx * ny);
}

}  // namespace

void fill_holes(const Grid& grid, CellSet& kept) {
  std::vector<std::uint8_t> neighbors(kept.size(), 0);
  std::vector<std::int64_t> queue;
  const auto count_at = [&](std::int64_t cell) {
    for_face_neighbors(grid, cell, [&](std::int64_t other) {
      if (++neighbors[other] == 4 && kept[other] == 0) queue.push_back(other);
    });
  };
  for (std::int64_t cell = 0; cell < grid.count(); ++cell)
    if (kept[cell] != 0) count_at(cell);
  while (!queue.empty()) {
    const std::int64_t cell = queue.back();
    queue.pop_back();
    kept[cell] = 1;
    count_at(cell);
  }
}

Components label_components(const Grid& grid, const CellSet& kept) {
  Components components;
  components.label.assign(kept.size(), -1);
  std::vector<std::int64_t> stack;
  for (std::int64_t seed = 0; seed < grid.count(); ++seed) {
    if (kept[seed] == 0 || components.label[seed] >= 0) continue;
    const auto label = static_cast<std::int32_t>(components.size.size());
    components.size.push_back(0);
    components.label[seed] = label;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::int64_t cell = stack.back();
      stack.pop_back();
      ++components.size[label];
      for_face_neighbors(grid, cell, [&](std::int64_t other) {
        if (kept[other] == 0 || components.label[other] >= 0) return;
        components.label[other] = label;
        stack.push_back(other);
      });
    }
  }
  return components;
}

void keep_largest(const Components& components, CellSet& kept) {
  if (components.size.size() < 2) return;
  const auto largest =
      static_cast<std::int32_t>(std::ranges::max_element(components.size) - components.size.begin());
  for (std::size_t cell = 0; cell < kept.size(); ++cell) kept[cell] = components.label[cell] == largest;
}

}  // namespace isochor
