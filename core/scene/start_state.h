#pragma once
#include "core/dynamics/soft_body.h"
#include "core/scene/scene.h"

namespace isochor {

/// Positions of a body's start: its rest shape, taken through the start's changes about the centre of mass.
Coordinates start_positions(const SoftBody& body, const StartState& start);

/// v + ω×(x − c).
Coordinates start_velocities(const SoftBody& body, const Vec3& velocity, const Vec3& angular_velocity);

}  // namespace isochor
