#pragma once
#include <optional>

#include "core/common/progress.h"
#include "core/distance_field/distance_field.h"
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// How the crossings of a line with a watertight soup tell inside from outside.
enum class Enclosing {
  parity,   ///< after an odd number of them: asks for no orientation, and a shell within a shell is a cavity
  winding,  ///< where their senses do not cancel out: parts that overlap are one solid
};

/// The voxels whose centres a watertight soup encloses, by the crossings of rows along x. Centres on the
/// surface itself are left out, so that a symmetric soup gives a symmetric answer. Nothing where so many
/// triangles lie over each other that their crossings are too many.
std::optional<BitVolume> enclosed_voxels(const TriangleSoup& soup, const DistanceField& field, Enclosing rule,
                                         const Progress& progress);

}  // namespace isochor
