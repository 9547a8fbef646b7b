#pragma once
#include <cstdint>
#include <vector>

#include "core/common/progress.h"
#include "core/pseudo_volume/pseudo_volume.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// From p to the surface of the pseudo volume, the faces between its voxels and the others, in model units:
/// to the nearest voxel of the other kind than the one p lies in. 1e300 where no voxel is inside.
double distance_to_surface(const PseudoVolume& volume, const Vec3& p);

/// The vertices of the surface, in order.
std::vector<std::int32_t> boundary_vertices(const TetMesh& mesh);

/// How far the boundary of a model lies from the surface of what it was made from, caps of openings and all;
/// in diagonals of a cell, over the boundary's vertices.
struct VoxelDistance {
  double max_diagonals = 0.0, mean_diagonals = 0.0;
};
VoxelDistance voxel_distance(const TetMesh& mesh, const PseudoVolume& volume, const Progress& progress);

}  // namespace isochor
