#include "core/lattice/node_link.h"
#include "core/lattice/topology.h"

namespace isochor {
namespace {

/// The four cells, as bits of a node's mask, around the lattice edge that leaves the node in the positive
/// direction of each axis: {a, b} and {c, d} are its two diagonals.
struct EdgeCells {
  int a, b, c, d;
};
constexpr std::array<EdgeCells, 3> edge_cells{{{1, 7, 3, 5}, {2, 7, 3, 6}, {4, 7, 5, 6}}};

bool is_contact(unsigned mask, const EdgeCells& e) {
  const bool a = mask >> e.a & 1, b = mask >> e.b & 1, c = mask >> e.c & 1, d = mask >> e.d & 1;
  return a == b && c == d && a != c;
}

bool is_node_contact(unsigned mask) {
  return mask == 0x81 || mask == 0x42 || mask == 0x24 || mask == 0x18;
}

/// Calls visit(node, mask) for every node of the grid with at least two kept cells.
template <class Visit>
void for_nodes(const Grid& grid, const CellSet& kept, Visit&& visit) {
  for (int k = 0; k <= grid.size.z(); ++k)
    for (int j = 0; j <= grid.size.y(); ++j)
      for (int i = 0; i <= grid.size.x(); ++i) {
        const unsigned mask = node_mask(grid, kept, i, j, k);
        if ((mask & (mask - 1)) != 0) visit(Vec3i(i, j, k), mask);
      }
}

void add_cells(const Grid& grid, const Vec3i& node, unsigned bits, CellSet& set) {
  for (int b = 0; b < 8; ++b)
    if (bits >> b & 1)
      set[grid.index(node.x() - 1 + (b & 1), node.y() - 1 + (b >> 1 & 1), node.z() - 1 + (b >> 2 & 1))] = 1;
}

}  // namespace

ContactCounts count_contacts(const Grid& grid, const CellSet& kept) {
  ContactCounts counts;
  for_nodes(grid, kept, [&](const Vec3i&, unsigned mask) {
    for (const EdgeCells& e : edge_cells) counts.edges += is_contact(mask, e);
    counts.nodes += is_node_contact(mask);
  });
  return counts;
}

std::int64_t fill_contacts(const Grid& grid, CellSet& kept) {
  std::int64_t contacts = 0;
  CellSet filled = kept;
  for_nodes(grid, kept, [&](const Vec3i& node, unsigned mask) {
    for (const EdgeCells& e : edge_cells) {
      if (!is_contact(mask, e)) continue;
      ++contacts;
      add_cells(grid, node, 1U << e.a | 1U << e.b | 1U << e.c | 1U << e.d, filled);
    }
    if (!is_node_contact(mask)) return;
    ++contacts;
    add_cells(grid, node, 0xFF, filled);
  });
  kept = std::move(filled);
  return contacts;
}

}  // namespace isochor
