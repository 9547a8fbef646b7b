#pragma once
#include <memory>
#include <optional>

#include "core/collision/shape.h"
#include "core/rigid/motion.h"
#include "core/rigid/rigid_body.h"

namespace isochor {

/// What a body carries within a step, for as long as the carried take turns: it answers to impulses as though
/// it had their mass as well, in its own shape. What it has been given but does not show by its velocities it
/// is owed.
struct CarriedLoad {
  double factor = 1.0;                                            ///< its mass with the load, over its own
  Vec3 velocity = Vec3::Zero(), angular_momentum = Vec3::Zero();  ///< its own, when it took the load
  Vec3 owed = Vec3::Zero(), owed_moment = Vec3::Zero();           ///< kg m/s, kg m²/s
  Vec3 center = Vec3::Zero();                                     ///< about which they are owed
};

/// A body of a RigidWorld: its state, what it looks like to collisions, and where its motion leads it.
struct BodyRecord {
  std::shared_ptr<const CollisionShape> shape;
  RigidBodyState state;
  double mass = 0.0;                                  ///< its own; state's are those with its load
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< likewise
  CarriedLoad load;
  bool jointed = false;
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
