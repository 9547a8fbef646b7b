#pragma once
#include "core/dynamics/particle_contacts.h"
#include "core/rigid/rigid_world.h"

namespace isochor {

/// Penetration that a substep leaves alone, in cells; frames promise a tenth of a percent.
constexpr double contact_slop = 1e-4;

/// Adds the planes of surface particles that are inside a rigid body at the end of the substep, or have
/// passed through one on their way (swept in the rigid body's frame). Particles already on a plane are looked
/// at again, since surfaces curve. True when something was added or moved. h is the substep's length.
bool detect_contacts(const SoftBody& body, const RigidWorld& world, double h, ParticleContacts& contacts);

/// Deepest surface particle in any rigid body at its present pose, m; pinned and attached ones are where the
/// scene wants them.
double deepest_penetration(const SoftBody& body, const RigidWorld& world, const ParticleContacts& contacts);

}  // namespace isochor
