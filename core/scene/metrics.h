#pragma once
#include "core/scene/world.h"

namespace isochor {

/// What a frame reports, recomputed from the state; stats adds what the substeps counted.
Metrics measure(const World& world, const StepStats& stats);

}  // namespace isochor
