#pragma once
#include <array>

#include "core/common/types.h"

namespace isochor {

/// One contact of a particle: at the end of the substep n·x ≥ offset.
struct ContactPlane {
  int source = 0;  ///< the rigid body; one plane each
  Vec3 normal = Vec3::UnitY();
  double offset = 0.0;
  Vec3 surface_shift = Vec3::Zero();  ///< of the surface's material during the substep
  double friction = 0.0, restitution = 0.0;
  double emerging = 0.0;  ///< m that a particle which began within the body comes out by in the substep
  double approach = 0.0;  ///< normal velocity between particle and surface at the substep's start, m/s
};

/// A particle and the planes that it touches.
struct ParticleContact {
  std::int32_t particle = 0;
  int planes = 0;
  std::array<ContactPlane, 3> plane;
  Vec3 push = Vec3::Zero();      ///< g
  Vec3 friction = Vec3::Zero();  ///< tangential part of r while it slips
  bool sticking = false;         ///< held in all directions
  bool torn = false;             ///< has left the cone in this substep: does not stick again
  bool moved = true;             ///< is to be placed
  bool attached = false;         ///< to the one plane's body at `anchor`, for good
  Vec3 anchor = Vec3::Zero();
};

/// The directions in which the contact holds its particle.
struct ContactDirections {
  Eigen::Matrix3d normal_space = Eigen::Matrix3d::Zero();  ///< projector on the span of the normals
  /// dual[k]·n_l = δ_kl within the span; zero for a plane that adds nothing to those before.
  std::array<Vec3, 3> dual{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
};
ContactDirections directions_of(const ParticleContact& contact);

/// The share of the reaction r that plane k bears: its part of the normal force, and an equal part of the
/// friction. The shares sum to r.
inline Vec3 share_of(const ParticleContact& contact, const ContactDirections& directions, int k,
                     const Vec3& reaction) {
  return contact.plane[k].normal * directions.dual[k].dot(reaction) +
         (reaction - directions.normal_space * reaction) / contact.planes;
}

}  // namespace isochor
