#pragma once
#include <memory>
#include <optional>

#include "core/collision/shape.h"
#include "core/rigid/motion.h"
#include "core/rigid/rigid_body.h"

namespace isochor {

/// A body of a RigidWorld: its state, what it looks like to collisions, and where its motion leads it.
struct BodyRecord {
  std::shared_ptr<const CollisionShape> shape;
  RigidBodyState state;
  double friction = 0.3, restitution = 0.0;
  double reach = 0.0;  ///< farthest point of the shape from the centre of mass

  std::optional<Motion> motion;  ///< of a body without mass, from `start` at t = 0
  Pose start, target;            ///< target: where the motion leads by the end of the step
  Vec3 motion_velocity = Vec3::Zero(), motion_spin = Vec3::Zero();  ///< that lead there

  bool dynamic() const { return state.dynamic(); }
  Vec3 velocity() const { return dynamic() ? state.velocity : motion_velocity; }
  Vec3 angular_velocity() const { return dynamic() ? state.angular_velocity() : motion_spin; }
  Pose predicted(double h) const { return dynamic() ? drift(state, h) : target; }
};

}  // namespace isochor
