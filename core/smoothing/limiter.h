#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/smoothing/boundary_graph.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Keeps moves of boundary vertices from spoiling tets. In Jacobi rounds, free of any order, the moves of all
/// vertices of tets under the floor are halved down to 1/256, then dropped; so a tet ends above the floor or
/// as it was. A vertex begins with twice the share of its last move.
class MoveLimiter {
 public:
  MoveLimiter(const TetMesh& mesh, const BoundaryGraph& graph);

  /// positions[vertices[b]] += the part of moves[b] that the floor allows.
  void apply(std::span<const Vec3> moves, double min_dihedral_deg, std::vector<Vec3>& positions,
             const Progress& progress);

  /// Vertices whose move was ever shortened.
  std::int64_t limited_vertices() const;

 private:
  void judge(std::int64_t begin, std::int64_t end, const std::vector<Vec3>& positions);
  bool shorten();
  void touch_changed();
  std::span<const std::int32_t> tets_of(std::int32_t v) const {
    return {tets_of_.data() + first_[v], static_cast<std::size_t>(first_[v + 1] - first_[v])};
  }

  const BoundaryGraph& graph_;
  std::vector<Tet> tets_;                      ///< those with a boundary vertex
  std::vector<std::int32_t> first_, tets_of_;  ///< see tets_of()
  double scale_, squared_cosine_ = 0.0;
  std::vector<double> share_;                ///< of the last move, a boundary vertex
  std::vector<std::uint8_t> limited_;        ///< a boundary vertex
  std::vector<std::int32_t> changed_;        ///< boundary vertices that this round moves
  std::vector<std::int32_t> touched_;        ///< tets around them
  std::vector<std::uint8_t> bad_;            ///< a touched tet
  std::vector<std::uint8_t> chosen_, seen_;  ///< a boundary vertex, a tet: stands in the list being made
};

}  // namespace isochor
