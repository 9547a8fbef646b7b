#pragma once
#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "core/dynamics/carrier_space.h"
#include "core/dynamics/particle_contact.h"
#include "core/dynamics/soft_body.h"

namespace isochor {

/// A rigid body with a mass, at the start of the substep.
struct MassiveBody {
  int source = 0;  ///< that contact planes name
  Vec3 center = Vec3::Zero();
  double mass = 0.0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< kg m², world axes
  bool jointed = false;                               ///< does not answer by its own mass alone
};

/// What a body is due from contacts, with its moment about its centre at the substep's start.
struct DueWrench {
  int source = 0;
  Vec3 center, push, moment;
};

/// How a body answers to a wrench about its centre, m and radians per kg m.
using ComplianceOf = std::function<Eigen::Matrix<double, 6, 6>(int source)>;

/// Speed that a particle is to gain along the normal against the body that it bounces off.
struct BounceGain {
  std::int32_t particle = 0;
  int source = 0;
  Vec3 normal;
  double speed = 0.0;
};

/// The rigid bodies with a mass that a deformable body touches. They feel −r of every contact's reaction r,
/// at the particle's start position as the constraints' directions do, so that no momentum is lost; and
/// within the volume projection they give way with the particles that press on them.
class ContactCarriers {
 public:
  /// A new substep: nothing has been handed out.
  void begin(std::span<const MassiveBody> bodies);
  /// The same bodies, in the same substep, with other masses.
  void weigh(std::span<const MassiveBody> bodies);
  bool empty() const { return bodies_.empty(); }
  bool carries(int source) const { return std::ranges::binary_search(bodies_, source, {}, &source_of); }

  /// Lists what each body carries and moves body and particles to where their momenta agree: q with
  /// (M + Σ BᵀmB)q = −Σ Bᵀr − what the body was given before. Of a jointed body M⁻¹ is its compliance.
  void load(SoftBody& body, std::span<const ParticleContact> contacts, const Coordinates& predicted,
            const ComplianceOf& compliance_of);
  std::span<RigidCarrier> carriers() { return carriers_; }

  /// The same for a solve with all of the body.
  const CarrierSpace& yielding(const SoftBody& body, std::span<const ParticleContact> contacts,
                               const ComplianceOf& compliance_of);

  /// What the reactions ask for beyond what was handed out before, impulse times h as they are; counts as
  /// handed out from now on.
  std::span<const DueWrench> take_due(const SoftBody& body, std::span<const ParticleContact> contacts,
                                      const Coordinates& predicted);
  /// Takes back what was handed out: the same list, of the opposite.
  std::span<const DueWrench> take_back();
  /// Handed something out in this substep, though it may have been taken back since.
  bool has_pushed(int source) const;
  /// Gives the particles that they carry, and the bodies in return, all gains at once; impulses in kg m/s.
  std::span<const DueWrench> bounce(SoftBody& body, std::span<const BounceGain> gains);
  /// Part of a particle's mass that friction may count on: touched bodies lighter than what rubs on them
  /// slip along. Of a new contact the mass is not among what touches yet.
  double friction_share(const ParticleContact& contact, double mass) const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Body {
    MassiveBody at_start;
    Vector6 given = Vector6::Zero();
    Vector6 rubbed = Vector6::Zero();  ///< by particles that slip: their friction, with its moment
    bool pushed = false;               ///< something was given
    double touching = 0.0;             ///< mass of its particles, kg
    std::vector<CarriedParticle> particles;
  };
  static int source_of(const Body& body) { return body.at_start.source; }
  Eigen::Matrix<double, 6, 6> combined_mass(const SoftBody& body, const Body& of) const;
  Eigen::Matrix<double, 6, 6> combined_compliance(const SoftBody& body, const Body& of,
                                                  const ComplianceOf& compliance_of) const;
  Body* find(int source);
  const Body* find(int source) const { return const_cast<ContactCarriers*>(this)->find(source); }
  void give(Body& body, const Vector6& due);
  void list_particles(const SoftBody& body, std::span<const ParticleContact> contacts);
  void sum_reactions(const SoftBody& body, std::span<const ParticleContact> contacts,
                     const Coordinates& predicted);

  std::vector<Body> bodies_;  ///< by source
  std::vector<Vector6> reactions_;
  std::vector<RigidCarrier> carriers_;
  CarrierSpace space_;
  std::vector<DueWrench> due_;
};

}  // namespace isochor
