#include "core/dynamics/newton_lattice.h"

#include <algorithm>

#include "core/dynamics/lattice_box.h"
#include "core/parallel/cancel_scope.h"

namespace isochor::newton {
namespace {

constexpr std::int64_t cells_a_slab = 192;

std::int64_t round_up(std::int64_t value) {
  return (value + chunk - 1) / chunk * chunk;
}

bool fits_lattice(const TetMesh& mesh) {
  if (mesh.nodes.size() != mesh.positions.size()) return false;
  for (const Cell& cell : mesh.cells)
    for (int b = 0; b < 8; ++b)
      for (int axis = 0; axis < 3; ++axis)
        if (mesh.nodes[cell.corners[b]][axis] != cell.coord[axis] + (b >> axis & 1)) return false;
  return true;
}

class LayoutBuilder {
 public:
  explicit LayoutBuilder(const TetMesh& mesh) : mesh_(mesh), bounds_(mesh) {
    const auto [nx, ny, nz] = bounds_.size;
    layout_.size = bounds_.size;
    layout_.strides.row = nx + 1;
    // A chunk that begins in the last row must not reach the next plane, not even from a corner in the row
    // behind: slabs of planes write their forces at the same time.
    layout_.strides.plane = round_up((ny + 1) * layout_.strides.row + chunk);
    const std::int64_t margin = round_up(layout_.strides.plane + layout_.strides.row + 1);
    layout_.origin = margin;
    layout_.first_extra = margin + (nz + 1) * layout_.strides.plane + margin;
  }

  LatticeLayout build() {
    place_vertices();
    throw_if_scope_cancelled();
    place_cells();
    throw_if_scope_cancelled();
    make_slabs();
    throw_if_scope_cancelled();
    // Arrays of this length follow each other: an odd number of cache lines keeps them out of each other's
    // sets.
    layout_.slots = round_up(layout_.first_extra + static_cast<std::int64_t>(layout_.extra_vertices.size()));
    layout_.slots += layout_.slots / chunk % 2 == 0 ? chunk : 0;
    return std::move(layout_);
  }

 private:
  std::int64_t slot(const std::array<int, 3>& coord) const {
    return layout_.origin + (coord[0] - bounds_.low[0]) + (coord[1] - bounds_.low[1]) * layout_.strides.row +
           (coord[2] - bounds_.low[2]) * layout_.strides.plane;
  }

  void place_vertices() {
    std::vector<std::uint8_t> taken(layout_.first_extra, 0);
    for (std::size_t v = 0; v < mesh_.nodes.size(); ++v) {
      std::int64_t place = slot(mesh_.nodes[v]);
      if (taken[place]) {
        place = layout_.first_extra + static_cast<std::int64_t>(layout_.extra_vertices.size());
        layout_.extra_vertices.emplace_back();
      } else {
        taken[place] = 1;
      }
      layout_.vertex_slots.push_back(static_cast<std::int32_t>(place));
      auto& runs = layout_.vertex_runs;
      if (!runs.empty() && runs.back().slot + runs.back().count == place)
        ++runs.back().count;
      else
        runs.push_back({static_cast<std::int32_t>(v), static_cast<std::int32_t>(place), 1});
    }
  }

  void place_cells() {
    layout_.kinds.assign(layout_.first_extra, LatticeLayout::none);
    for (const Cell& cell : mesh_.cells) {
      layout_.cell_slots.push_back(static_cast<std::int32_t>(slot(cell.coord)));
      LatticeLayout::IrregularCell irregular{layout_.cell_slots.back(), {}};
      bool regular = true;
      for (int b = 0; b < 8; ++b) {
        irregular.corners[b] = layout_.vertex_slots[cell.corners[b]];
        if (irregular.corners[b] < layout_.first_extra) continue;
        regular = false;
        layout_.extra_vertices[irregular.corners[b] - layout_.first_extra].push_back(
            {static_cast<std::int32_t>(layout_.irregular_cells.size()), b});
      }
      if (!regular) layout_.irregular_cells.push_back(irregular);
      layout_.kinds[irregular.slot] =
          regular ? (cell.parity() ? LatticeLayout::odd : LatticeLayout::even)
                  : (cell.parity() ? LatticeLayout::irregular_odd : LatticeLayout::irregular_even);
    }
  }

  void make_slabs() {
    const std::int64_t planes = bounds_.size[2] + 1;
    std::vector<std::int64_t> cells_of_plane(planes, 0);
    std::vector<std::uint8_t> cell_chunks(layout_.first_extra / chunk, 0), node_chunks = cell_chunks;
    for (const std::int32_t s : layout_.cell_slots) {
      cell_chunks[s / chunk] = 1;
      ++cells_of_plane[(s - layout_.origin) / layout_.strides.plane];
    }
    for (const std::int32_t s : layout_.vertex_slots)
      if (s < layout_.first_extra) node_chunks[s / chunk] = 1;
    std::int64_t cells = 0, first = 0, left = std::ssize(layout_.cell_slots);
    for (std::int64_t plane = 0; plane < planes; ++plane) {
      cells += cells_of_plane[plane];
      left -= cells_of_plane[plane];
      // The last ones take what is less than half a slab, the nodes behind the last cells at least.
      const bool last = plane + 1 == planes;
      if (!last && (cells < cells_a_slab || left < cells_a_slab / 2)) continue;
      layout_.slabs.push_back({runs(cell_chunks, first, plane + 1), runs(node_chunks, first, plane + 1),
                               first, std::min<std::int64_t>(plane + 1, bounds_.size[2]) - first});
      cells = 0;
      first = plane + 1;
    }
    const auto extra = static_cast<std::int64_t>(layout_.extra_vertices.size());
    if (extra > 0)
      layout_.slabs.back().nodes.push_back(
          {static_cast<std::int32_t>(layout_.first_extra),
           static_cast<std::int32_t>(layout_.first_extra + round_up(extra))});
  }

  std::vector<Run> runs(const std::vector<std::uint8_t>& chunks, std::int64_t first, std::int64_t end) const {
    const std::int64_t stride = layout_.strides.plane / chunk, base = layout_.origin / chunk;
    std::vector<Run> result;
    for (std::int64_t c = base + first * stride; c < base + end * stride; ++c) {
      if (!chunks[c]) continue;
      const auto begin = static_cast<std::int32_t>(c * chunk);
      if (!result.empty() && result.back().end == begin)
        result.back().end += chunk;
      else
        result.push_back({begin, begin + chunk});
    }
    return result;
  }

  const TetMesh& mesh_;
  LatticeBox bounds_;
  LatticeLayout layout_;
};

}  // namespace

std::int64_t LatticeLayout::irregular_index(std::int64_t cell) const {
  const auto before = [](const IrregularCell& a, std::int64_t slot) { return a.slot < slot; };
  return std::lower_bound(irregular_cells.begin(), irregular_cells.end(), cell, before) -
         irregular_cells.begin();
}

std::optional<LatticeLayout> make_lattice_layout(const TetMesh& mesh) {
  if (mesh.cells.empty() || !fits_lattice(mesh)) return std::nullopt;
  throw_if_scope_cancelled();
  return LayoutBuilder(mesh).build();
}

}  // namespace isochor::newton
