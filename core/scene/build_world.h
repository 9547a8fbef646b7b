#pragma once
#include "core/common/progress.h"
#include "core/scene/world.h"

namespace isochor {

/// Bodies, pins and rigid bodies of a scene at their start. Meshes are read and meshed here. Throws
/// invalid_argument, cannot_read, empty_result, over_budget, cancelled.
World build_world(const Scene& scene, Progress& progress);

/// k = E·cell_size where a modulus is given.
SpringMaterial spring_material(const SpringSettings& springs, double cell_size);

/// Springs, masses of pins and the volume solver of one body, again after a change of material or solver.
void build_springs(SceneSoftBody& soft);
void build_projector(SceneSoftBody& soft, const SolverOptions& solver);

/// Time, and the motion of the bodies that have a namesake in `before`.
void continue_state(World& world, const World& before);

}  // namespace isochor
