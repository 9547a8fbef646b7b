#pragma once
#include "core/distance_field/block_kernel.h"
#include "core/distance_field/distance_field.h"

namespace isochor {

/// Fills field.distance, which has its size already, with the given kernel, and sets field.max_distance.
void fill_distances(const TriangleSoup& soup, const BlockKernel& kernel, DistanceField& field,
                    Progress& progress);

}  // namespace isochor
