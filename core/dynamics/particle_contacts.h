#pragma once
#include <span>
#include <vector>

#include "core/dynamics/contact_carriers.h"
#include "core/dynamics/soft_body.h"

namespace isochor {

/// The active set of a body's contacts within one substep. A contact blocks the particle along its normal
/// inside the volume projection; the projection tells what the volume presses on it, and from this follow
/// release (no contact pulls) and Coulomb's cone (stick or slip), until nothing changes. With x̂ the predicted
/// position and g the volume's push, the contact's reaction is r = m(x − x̂) − g (kg·m: impulse times h).
class ParticleContacts {
 public:
  explicit ParticleContacts(const SoftBody& body);

  /// A new substep: no contact, x̂ = the body's positions. Friction starts from what is remembered. Planes of
  /// the bodies given are carried by them. with_body: the contacts are solved with all of the body
  /// (set_reactions), so that what touches is moved onto its planes and nowhere else.
  void begin(const SoftBody& body, double h, std::span<const MassiveBody> bodies = {},
             bool with_body = false);
  /// The substep stands: the next one starts from its friction. Not so when it is taken back, or friction
  /// that did not balance would throw every substep that is tried after it.
  void remember();
  /// The bodies of begin() have other masses from now on.
  void weigh(std::span<const MassiveBody> bodies) { carriers_.weigh(bodies); }
  bool empty() const { return particles_.empty(); }
  bool with_body() const { return with_body_; }
  std::int64_t count() const { return static_cast<std::int64_t>(particles_.size()); }

  /// Adds a plane, or replaces that of the same source.
  void set_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane);
  bool touches(std::int32_t particle) const;
  /// Holds a particle on a body of begin(), at the anchor at the substep's end. Again with another anchor
  /// when the body has gone elsewhere: true when that is farther than the slop (m).
  bool attach(const SoftBody& body, std::int32_t particle, int source, const Vec3& anchor, double slop);
  bool attached(std::int32_t particle) const {
    return slot_[particle] >= 0 && particles_[slot_[particle]].attached;
  }
  /// The particle's plane of that source, or null.
  const ContactPlane* plane_of(std::int32_t particle, int source) const;
  std::span<const ParticleContact> contacts() const { return particles_; }
  /// Replaces the plane of the same source. True when that leaves the particle off its place by more than the
  /// slop (m).
  bool renew_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane, double slop);

  /// The friction of each blocked particle (kg·m), where it does not stick.
  std::span<const Vec3> frictions();
  /// The reactions of the blocked particles (kg·m, in the order of blocked()) are known from a solve that
  /// moved the whole body: x̂ becomes what gives them.
  void set_reactions(const SoftBody& body, std::span<const Vec3> reactions);

  /// Moves every particle whose contacts have changed to where they let it be, and lists the blocked ones.
  void place(SoftBody& body);
  std::span<const BlockedParticle> blocked() const { return blocked_; }
  /// Blocks them along their normals alone, until they are placed again.
  void let_slide(const SoftBody& body);
  std::span<Vec3> blocked_forces() { return forces_; }
  /// The bodies of begin() give way to what presses on them, and move on with their particles within the
  /// projection.
  void carry(SoftBody& body, const ComplianceOf& compliance_of) {
    carriers_.load(body, particles_, predicted_, compliance_of);
  }
  /// For a solve that moves the whole body: how they give way then.
  const CarrierSpace& yielding(const SoftBody& body, const ComplianceOf& compliance_of) {
    return carriers_.yielding(body, particles_, compliance_of);
  }
  std::span<RigidCarrier> carriers() { return carriers_.carriers(); }
  /// What these bodies are due since the last call.
  std::span<const DueWrench> take_due(const SoftBody& body) {
    return carriers_.take_due(body, particles_, predicted_);
  }

  std::span<const DueWrench> take_back() { return carriers_.take_back(); }
  /// A body was due something in this substep, though it may have been taken back since.
  bool has_pushed(int source) const { return carriers_.has_pushed(source); }
  /// The sum of all reactions, kg·m.
  Vec3 push(const SoftBody& body) const;

  /// Reads the forces of the last projection, once; scaled, where its displacement was.
  void take_forces(double scale = 1.0);
  /// How a particle moves under a force (kg·m) while its planes hold it.
  Vec3 respond(const SoftBody& body, std::int32_t particle, const Vec3& force) const;
  /// Forces from elsewhere have moved x̂ of a particle.
  void shift(std::int32_t particle, const Vec3& by) { predicted_.add(particle, by); }
  /// Does so, and judges by them. True when a contact was released, or friction_tolerance of all friction
  /// together has changed.
  bool update(const SoftBody& body, bool may_release);

  /// v_n = −e·(approach) for the contacts that press [after Bender & Schmitt 2006]. Returns what the bodies
  /// of begin() are due for it, kg m/s.
  std::span<const DueWrench> bounce(SoftBody& body, double h);

  /// After the kick that ends a substep: takes back what of it goes against contacts, which answer to it only
  /// in the next one, so that velocities are those of what is held. give_back() starts that next one with it,
  /// and positions are the same. Not for bodies of begin(), whose momentum counts at the end of a substep.
  void hold_back(SoftBody& body, double seconds, const Vec3& gravity);
  void give_back(SoftBody& body) const;

  /// What moving surfaces have done on the particles in this substep: the reactions by the shifts of the
  /// surfaces, J.
  double work(const SoftBody& body) const;
  /// Some particle began the substep within a body and is on its way out.
  bool emerging() const;
  /// What pushes these out does on them by that, J: the normal reactions by the ways out.
  double emerging_work(const SoftBody& body) const;
  /// A surface in contact moves in this substep.
  bool on_the_move() const;

  std::int64_t bytes() const;

 private:
  using Contact = ParticleContact;

  /// Of a contact in the substep before.
  struct Memory {
    std::int32_t particle = 0;
    Vec3 friction = Vec3::Zero();  ///< N
    bool sticking = false;
  };

  struct HeldKick {
    std::int32_t particle = 0;
    Vec3 velocity = Vec3::Zero();
  };

  const Memory* recall(std::int32_t particle) const;
  void guess_friction(const SoftBody& body, Contact& contact) const;
  Vec3 target(const SoftBody& body, const Contact& contact) const;
  Vec3 reaction(const SoftBody& body, const Contact& contact) const;
  bool release(Contact& contact, const Vec3& reaction);
  double rub(const SoftBody& body, Contact& contact, const Vec3& tangential, double limit);

  Coordinates predicted_;
  ContactCarriers carriers_;
  std::vector<Contact> particles_;
  std::vector<BlockedParticle> blocked_;
  std::vector<Vec3> forces_, frictions_;
  std::vector<std::int32_t> slot_;  ///< of each particle in particles_, or −1
  std::vector<Memory> memory_;
  std::vector<std::int32_t> memory_slot_;
  std::vector<BounceGain> gains_;
  std::vector<HeldKick> held_back_;
  double h_ = 0.0;
  bool with_body_ = false;
};

}  // namespace isochor
