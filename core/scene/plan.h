#pragma once
#include "core/scene/world.h"

namespace isochor {

/// Chooses the integrator of each body and the substeps of a frame, and decides which phases the world needs,
/// each with its reason. Again after every live change.
void plan_phases(World& world);

/// Memory that each phase holds now.
void measure_phases(World& world);

}  // namespace isochor
