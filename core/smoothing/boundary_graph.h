#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/smoothing/smoothing.h"

namespace isochor {

/// The boundary surface as a graph of its own: boundary vertices and, of each, its neighbours as indices into
/// `vertices`, ascending.
struct BoundaryGraph {
  std::vector<std::int32_t> vertices;  ///< vertex of the mesh, ascending
  std::vector<std::int32_t> index;     ///< of each vertex of the mesh, -1 inside
  std::vector<std::int32_t> first;     ///< neighbours of v stand at [first[v], first[v+1])
  std::vector<std::int32_t> neighbors;

  std::span<const std::int32_t> neighbors_of(std::int64_t v) const {
    return {neighbors.data() + first[v], static_cast<std::size_t>(first[v + 1] - first[v])};
  }
};

/// Axis-aligned edges are those whose lattice nodes differ along one axis only: the unsmoothed mesh decides.
BoundaryGraph make_boundary_graph(const TetMesh& mesh, UmbrellaEdges edges);

}  // namespace isochor
