#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/collision/shape.h"
#include "core/rigid/motion.h"
#include "core/rigid/rigid_body.h"

namespace isochor {

struct RigidBodyDesc {
  std::shared_ptr<const CollisionShape> shape;
  Pose pose;                     ///< of the centre of mass
  std::optional<double> mass;    ///< kg; absent: static, or moved by `motion`
  std::optional<Motion> motion;  ///< takes precedence over mass
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  ///< of a body with a mass
  double friction = 0.3, restitution = 0.0;
};

/// What the last step did.
struct RigidMetrics {
  std::int64_t contacts = 0;     ///< points that pressed
  double max_penetration = 0.0;  ///< metres, at the end of the step
  double max_joint_error = 0.0;  ///< metres (radians for axes), at the end of the step
  int iterations = 0;            ///< Newton rounds of the solver, both stages
  bool converged = true;
};

/// Rigid bodies, their joints and contacts. One substep is
///   begin_step(h)   kinematic velocities, impacts, half of gravity, contacts found
///   solve()         impulses so that joints and contacts hold at the predicted poses (SHAKE)
///   end_step()      poses move, the other half of gravity, impulses so that velocities agree (RATTLE)
/// Between begin and end anybody may apply impulses, ask for predicted poses and solve again: that is how
/// deformable bodies take part. Deterministic, single-threaded, no allocation once warm.
class RigidWorld {
 public:
  RigidWorld();
  ~RigidWorld();
  RigidWorld(RigidWorld&&) noexcept;
  RigidWorld& operator=(RigidWorld&&) noexcept;

  /// Bodies are numbered from 0 in the order in which they are added. Throws invalid_argument.
  int add_body(const RigidBodyDesc& desc);
  void set_gravity(const Vec3& gravity);

  void step(double h) { begin_step(h), solve(), end_step(); }
  void begin_step(double h);
  void solve();
  void end_step();

  int size() const;
  const CollisionShape& shape(int body) const;
  double friction(int body) const;
  double restitution(int body) const;
  bool dynamic(int body) const;   ///< has a finite mass
  bool immobile(int body) const;  ///< neither a mass nor a motion
  const RigidBodyState& state(int body) const;
  const Pose& pose(int body) const { return state(body).pose; }
  /// Where the step under way will leave the body at its present velocity; its pose outside of a step.
  Pose predicted_pose(int body) const;
  /// Velocity of the body's material at a world point, kinematic bodies included.
  Vec3 velocity_at(int body, const Vec3& point) const;
  Eigen::Matrix3d inverse_mass_at(int body, const Vec3& point) const;  ///< zero unless dynamic
  void apply_impulse(int body, const Vec3& point, const Vec3& impulse);

  /// A body without mass goes to the pose within the given time from now, or at once when it is 0.
  void move_body(int body, const Pose& pose, double duration);

  double time() const;
  double kinetic_energy() const;  ///< of the dynamic bodies, as all totals
  double gravity_energy() const;  ///< −Σ m g·x
  Vec3 linear_momentum() const;
  Vec3 angular_momentum() const;  ///< about the world's origin
  const RigidMetrics& metrics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isochor
