#pragma once
#include "core/dynamics/particle_contacts.h"
#include "core/rigid/rigid_world.h"

namespace isochor {

/// Penetration that a substep leaves alone, in cells; frames promise a tenth of a percent.
constexpr double contact_slop = 1e-4;

/// Where the first round of a substep has found surface particles near rigid bodies without a mass, whose way
/// is known then. Later rounds look at these alone, as long as nothing has moved far since.
struct ContactCandidates {
  std::vector<std::vector<std::int32_t>> near;  ///< a rigid body
  Coordinates seen;                             ///< positions in that round
  bool known = false;

  explicit ContactCandidates(std::size_t particles) : seen(particles) {}
  std::int64_t bytes() const;
};

/// Adds the planes of surface particles that are inside a rigid body at the end of the substep, or have
/// passed through one on their way (swept in the rigid body's frame). Particles already on a plane are looked
/// at again, since surfaces curve. True when something was added or moved. h is the substep's length.
bool detect_contacts(const SoftBody& body, const RigidWorld& world, double h, ContactCandidates& candidates,
                     ParticleContacts& contacts);

/// Deepest surface particle in any rigid body at its present pose, m; pinned and attached ones are where the
/// scene wants them.
double deepest_penetration(const SoftBody& body, const RigidWorld& world, const ParticleContacts& contacts);

}  // namespace isochor
