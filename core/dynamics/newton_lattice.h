#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/dynamics/newton_kernels.h"
#include "core/parallel/parallel.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor::newton {

/// Where a body's cells and vertices lie in flat arrays over its bounding lattice (Strides). Rows end in one
/// empty slot and planes in an empty row, so that every neighbour of a cell exists and is zero where there is
/// none. Where two vertices share a lattice node (separated meshes), all but the first lie behind the
/// lattice, and their cells are irregular: treated one by one.
struct LatticeLayout {
  struct VertexRun {
    std::int32_t vertex, slot, count;
  };
  struct IrregularCell {
    std::int32_t slot;
    std::array<std::int32_t, 8> corners;  ///< slots
  };
  /// A corner of an irregular cell that lies behind the lattice.
  struct Incidence {
    std::int32_t cell, corner;  ///< cell: index into irregular_cells
  };
  /// Some whole planes of the lattice: the unit of parallel work, large enough to be worth a thread's time.
  struct Slab {
    std::vector<Run> cells, nodes;     ///< chunks with a cell, with a vertex
    std::int64_t first_plane, planes;  ///< of cells
  };
  /// Bodies of fewer slabs are done before a second thread has woken up.
  static constexpr std::size_t fewest_parallel_slabs = 8;

  enum Kind : std::uint8_t { none, even, odd, irregular_even, irregular_odd };

  std::array<int, 3> size;  ///< cells an axis
  Strides strides;
  std::int64_t origin;  ///< slot of the first cell
  std::int64_t slots;
  std::vector<std::int32_t> cell_slots, vertex_slots;
  std::vector<Kind> kinds;  ///< of a slot's cell
  std::vector<VertexRun> vertex_runs;
  std::vector<IrregularCell> irregular_cells;          ///< in slot order
  std::vector<std::vector<Incidence>> extra_vertices;  ///< a vertex behind the lattice, in slot order
  std::int64_t first_extra;                            ///< slot of the first of these
  std::vector<Slab> slabs;

  int parity(std::int64_t cell) const { return kinds[cell] == odd || kinds[cell] == irregular_odd; }
  bool irregular(std::int64_t cell) const { return kinds[cell] >= irregular_even; }
  std::int64_t irregular_index(std::int64_t cell) const;
  std::int64_t corner_offset(int corner) const {
    return (corner & 1) + (corner >> 1 & 1) * strides.row + (corner >> 2 & 1) * strides.plane;
  }
  /// Of a cell within the box.
  std::array<int, 3> coord(std::int64_t cell) const {
    const std::int64_t offset = cell - origin, in_plane = offset % strides.plane;
    return {static_cast<int>(in_plane % strides.row), static_cast<int>(in_plane / strides.row),
            static_cast<int>(offset / strides.plane)};
  }
  /// Slot of a cell's corner.
  std::int64_t corner_slot(std::int64_t cell, int corner) const {
    return irregular(cell) ? irregular_cells[irregular_index(cell)].corners[corner]
                           : cell + corner_offset(corner);
  }
  /// Calls body(index of the slab, slab) for all slabs first, first + step, …, on all threads.
  template <class Body>
  void for_slabs(const Body& body, std::int64_t first = 0, std::int64_t step = 1) const {
    const auto count = static_cast<std::int64_t>(slabs.size());
    const auto range = [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = first + begin * step; i < first + end * step && i < count; i += step)
        body(i, slabs[i]);
    };
    const std::int64_t turns = (count - first + step - 1) / step;
    if (slabs.size() < fewest_parallel_slabs)
      range(0, turns);
    else
      parallel_for(turns, 1, range, Work::alike);
  }
  /// Calls visit(slot of the cell, corner) for all cells at a vertex.
  template <class Visit>
  void visit_cells(std::int64_t vertex, const Visit& visit) const {
    if (vertex >= first_extra) {
      for (const auto& [cell, corner] : extra_vertices[vertex - first_extra])
        visit(std::int64_t{irregular_cells[cell].slot}, corner);
      return;
    }
    for (int b = 0; b < 8; ++b) {
      const std::int64_t cell = vertex - corner_offset(b);
      if (kinds[cell] != none && corner_slot(cell, b) == vertex) visit(cell, b);
    }
  }
};

inline Runs as_runs(const std::vector<Run>& runs) {
  return {runs.data(), static_cast<std::int64_t>(runs.size())};
}

/// Nothing when a corner of a cell is not where the lattice has it.
std::optional<LatticeLayout> make_lattice_layout(const TetMesh& mesh);

}  // namespace isochor::newton
