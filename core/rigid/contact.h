#pragma once
#include <array>

#include "core/collision/manifold.h"
#include "core/rigid/broad_phase.h"
#include "core/rigid/impulse_solver.h"

namespace isochor {

/// A contact point carried along by its bodies through a step.
struct RigidContact {
  int a = 0, b = 0;
  Vec3 local_a, local_b, normal;  ///< core points; the normal in its owner's frame
  double radius_a = 0.0, radius_b = 0.0;
  NormalOwner owner = NormalOwner::world;
  double friction = 0.0, restitution = 0.0;
  bool ahead = false;           ///< the bodies are still apart at the start of the step
  double least_gap = 0.0;       ///< m, at the step's end; below 0 where bodies placed in each other come out
  double approach = 0.0;        ///< m/s at which the bodies met; 0 for a resting contact
  Vec3 impulse = Vec3::Zero();  ///< onto a in the last stage, to start the next one from
};

inline BodyPair pair_of(const RigidContact& contact) {
  return {contact.a, contact.b};
}

RigidContact make_contact(int a, int b, const ManifoldPoint& point, const Pose& pose_a, const Pose& pose_b);

Vec3 contact_normal(const RigidContact& contact, const Pose& a, const Pose& b);
double contact_gap(const RigidContact& contact, const Pose& a, const Pose& b);

/// Normal and two tangents at the poses, without residuals and impulses.
void append_contact_rows(const RigidContact& contact, const Pose& a, const Pose& b, ConstraintSet& set);

}  // namespace isochor
