#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/smoothing/boundary_graph.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Keeps moves of boundary vertices from spoiling tets. In Jacobi rounds, free of any order, the moves of all
/// vertices of tets under the floor are halved, at most 8 times, then dropped; so a tet ends above the floor
/// or as it was.
class MoveLimiter {
 public:
  MoveLimiter(const TetMesh& mesh, const BoundaryGraph& graph, double min_dihedral_deg);

  /// positions[vertices[b]] += the part of moves[b] that the floor allows.
  void apply(std::span<const Vec3> moves, std::vector<Vec3>& positions, const Progress& progress);

  /// Vertices whose move was ever shortened.
  std::int64_t limited_vertices() const;

 private:
  bool is_bad(const Tet& tet, const std::vector<Vec3>& positions) const;
  bool shorten(bool drop, const std::vector<Vec3>& positions);

  const BoundaryGraph& graph_;
  std::vector<Tet> tets_;  ///< those with a boundary vertex
  double max_cosine_, min_volume_;
  std::vector<double> share_;                           ///< of the move, a boundary vertex
  std::vector<std::uint8_t> changed_, next_, limited_;  ///< a boundary vertex
  std::vector<std::uint8_t> bad_;                       ///< a tet
};

}  // namespace isochor
