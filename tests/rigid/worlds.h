#pragma once
#include <cmath>

#include "core/rigid/rigid_world.h"

namespace isochor {

inline RigidBodyDesc rigid(std::unique_ptr<CollisionShape> shape, std::optional<double> mass,
                           const Vec3& position) {
  RigidBodyDesc desc;
  desc.shape = std::move(shape);
  desc.mass = mass;
  desc.pose.position = position;
  return desc;
}

/// A floor through the origin under gravity.
inline RigidWorld world_with_floor(double friction, double restitution, const Vec3& normal = Vec3::UnitY()) {
  RigidWorld world;
  world.set_gravity({0.0, -9.81, 0.0});
  RigidBodyDesc floor = rigid(make_plane(normal, 0.0), std::nullopt, Vec3::Zero());
  floor.friction = friction;
  floor.restitution = restitution;
  world.add_body(floor);
  return world;
}

inline void run(RigidWorld& world, double seconds, double h) {
  const int steps = static_cast<int>(std::lround(seconds / h));
  for (int i = 0; i < steps; ++i) world.step(h);
}

}  // namespace isochor
