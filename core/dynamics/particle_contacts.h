#pragma once
#include <span>
#include <vector>

#include "core/dynamics/soft_body.h"

namespace isochor {

/// One contact of a particle: at the end of the substep n·x ≥ offset.
struct ContactPlane {
  int source = 0;  ///< the rigid body; one plane each
  Vec3 normal = Vec3::UnitY();
  double offset = 0.0;
  Vec3 surface_shift = Vec3::Zero();  ///< of the surface's material during the substep
  double friction = 0.0, restitution = 0.0;
  double approach = 0.0;  ///< normal velocity between particle and surface at the substep's start, m/s
};

/// The active set of a body's contacts within one substep. A contact blocks the particle along its normal
/// inside the volume projection; the projection tells what the volume presses on it, and from this follow
/// release (no contact pulls) and Coulomb's cone (stick or slip), until nothing changes. With x̂ the predicted
/// position and g the volume's push, the contact's reaction is r = m(x − x̂) − g (kg·m: impulse times h).
class ParticleContacts {
 public:
  explicit ParticleContacts(const SoftBody& body);

  /// A new substep: no contact, x̂ = the body's positions. Friction starts from that of the last one.
  void begin(const SoftBody& body, double h);
  bool empty() const { return particles_.empty(); }
  std::int64_t count() const { return static_cast<std::int64_t>(particles_.size()); }

  /// Adds a plane, or replaces that of the same source.
  void set_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane);
  bool touches(std::int32_t particle) const;

  /// Moves every particle whose contacts have changed to where they let it be, and lists the blocked ones.
  void place(SoftBody& body);
  std::span<const BlockedParticle> blocked() const { return blocked_; }
  std::span<Vec3> blocked_forces() { return forces_; }

  /// Reads the forces of the last projection. True when a contact was released or torn off, or friction has
  /// changed by more than a twentieth of its limit.
  bool update(const SoftBody& body, bool may_release);

  /// v_n = −e·(approach) for the contacts that press [after Bender & Schmitt 2006].
  void bounce(SoftBody& body, double h) const;

  std::int64_t bytes() const;

 private:
  struct Contact {
    std::int32_t particle = 0;
    int planes = 0;
    std::array<ContactPlane, 3> plane;
    Vec3 push = Vec3::Zero();      ///< g
    Vec3 friction = Vec3::Zero();  ///< tangential part of r while it slips
    bool sticking = false;         ///< held in all directions
    bool torn = false;             ///< has left the cone in this substep: does not stick again
    bool moved = true;             ///< is to be placed
  };

  /// Of a contact in the substep before.
  struct Memory {
    std::int32_t particle = 0;
    Vec3 friction = Vec3::Zero();  ///< N
    bool sticking = false;
  };

  const Memory* recall(std::int32_t particle) const;
  void guess_friction(const SoftBody& body, Contact& contact) const;
  Vec3 target(const SoftBody& body, const Contact& contact) const;
  bool release(Contact& contact, const Vec3& reaction);
  bool rub(const SoftBody& body, Contact& contact, const Vec3& reaction);

  Coordinates predicted_;
  std::vector<Contact> particles_;
  std::vector<BlockedParticle> blocked_;
  std::vector<Vec3> forces_;
  std::vector<std::int32_t> slot_;  ///< of each particle in particles_, or −1
  std::vector<Memory> memory_;
  std::vector<std::int32_t> memory_slot_;
  double h_ = 0.0;
};

}  // namespace isochor
