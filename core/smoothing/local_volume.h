#pragma once
#include <array>
#include <vector>

#include "core/smoothing/boundary_graph.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Keeps moves of boundary vertices from taking volume away from a place: what a move takes is given back, to
/// first order, along the normals of the vertex and its neighbours. Smoothing alone shrinks a branch one cell
/// thick by 12 % an iteration; rescaling the whole makes that up in its length.
class LocalVolume {
 public:
  LocalVolume(const TetMesh& mesh, const BoundaryGraph& graph);

  /// positions: of the boundary vertices, as `moves`.
  void balance(const std::vector<Vec3>& positions, std::vector<Vec3>& moves);

 private:
  void update_normals(const std::vector<Vec3>& positions);

  const BoundaryGraph& graph_;
  /// The lattice's faces, the diagonals (0,2) and (1,3): its triangles would tell the patterns of tets apart.
  std::vector<std::array<std::int32_t, 4>> faces_;
  std::vector<Vec3> normals_;  ///< ∂V/∂x of each vertex: a quarter of its faces' area vectors
  std::vector<double> areas_;  ///< a quarter of their areas
  std::vector<double> taken_;  ///< volume, a vertex and each of its neighbours
};

}  // namespace isochor
