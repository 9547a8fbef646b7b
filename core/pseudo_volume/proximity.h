#pragma once
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// Clears the bits of `voxels` that have a set bit of `others` within `radius` voxels (under 64), centre to
/// centre.
void remove_near(BitVolume& voxels, const BitVolume& others, double radius);

}  // namespace isochor
