#pragma once
#include <span>

#include "core/common/types.h"

namespace isochor {

/// The 26 lattice directions: 6 along the axes, then 8 along the space diagonals, then 12 along the face
/// diagonals, so that the first 6, 14 or 26 are the sets on offer. Both senses of each line are in, because
/// the rule is not symmetric.
std::span<const Vec3i> ray_directions();

}  // namespace isochor
