#pragma once
#include <array>

#include "core/dynamics/particle_contacts.h"

namespace isochor {

/// A deformable body as the contacts of surfaces see it.
struct SurfaceBody {
  SoftBody* body = nullptr;
  ParticleContacts* contacts = nullptr;  ///< with rigid bodies; null without any
  bool touched = false;                  ///< by a contact of this substep
};

/// A vertex in front of a triangle: at the end of the substep n·(x − Σ w_k x_k) ≥ g, as a rule 0.
struct SurfaceContact {
  int owner = 0, other = 0;  ///< bodies of the vertex and of the triangle
  std::int32_t vertex = 0;
  Triangle triangle{};  ///< particles of the other body
  /// Where on the triangle the vertex stands as the substep begins, so that the forces have no moment; with n
  /// normal to the triangle as it is now, any weights give the same gap.
  Vec3 weights = Vec3::Constant(1.0 / 3.0);
  Vec3 normal = Vec3::UnitY();  ///< of the triangle
  double friction = 0.0, restitution = 0.0;
  /// Of the gap at the end, m: 0, or less where the vertex stood behind the triangle as the substep began. To
  /// put it right at once would make a speed of it.
  double least_gap = 0.0;
  double approach = 0.0;  ///< normal velocity of the vertex against the triangle as the substep began, m/s
  double mobility = 0.0;  ///< Σ c²/m, 1/kg
  Vec3 impulse = Vec3::Zero();  ///< λ on the vertex, kg·m: impulse times h; Σ −w_k λ on the triangle
  std::int32_t next = -1;       ///< contact of the same vertex

  double pressure() const { return normal.dot(impulse); }
  Vec3 tangential(const Vec3& v) const { return v - normal * normal.dot(v); }
};

}  // namespace isochor
