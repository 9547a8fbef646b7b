#pragma once
#include "core/scene/world.h"

namespace isochor {

/// Chooses the integrator of each body and the substeps of a frame, and decides which phases the world needs,
/// each with its reason. Again after every live change.
void plan_phases(World& world);

/// Writes the memory that each phase holds now; some of it is not taken before it is used.
void measure_phases(const World& world, PhaseList& phases);

}  // namespace isochor
