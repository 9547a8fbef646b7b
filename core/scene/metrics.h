#pragma once
#include "core/scene/world.h"

namespace isochor {

/// Cells by which the end of a feasible frame leaves deformable bodies in others and in themselves at most.
inline constexpr double promised_depth = 1e-3;

/// What a frame reports, recomputed from the state; stats adds what the substeps counted.
Metrics measure(const World& world, const StepStats& stats);

}  // namespace isochor
