#pragma once
#include "core/distance_field/block_kernel.h"
#include "core/distance_field/distance_field.h"

namespace isochor {

inline constexpr int least_voxels = 16;

/// The grid over a box that is neither empty nor a point.
Grid grid_of_box(const Box& box, const DistanceFieldOptions& options);

/// Fills field.distance, which has its size already, with the given kernel, and sets field.max_distance.
void fill_distances(const TriangleSoup& soup, const BlockKernel& kernel, DistanceField& field,
                    Progress& progress);

}  // namespace isochor
