#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/collision/shape.h"
#include "core/rigid/joint.h"
#include "core/rigid/motion.h"
#include "core/rigid/rigid_body.h"
#include "core/rigid/rigid_metrics.h"

namespace isochor {

struct RigidBodyDesc {
  std::shared_ptr<const CollisionShape> shape;
  Pose pose;                     ///< of the centre of mass
  std::optional<double> mass;    ///< kg; absent: static, or moved by `motion`
  std::optional<Motion> motion;  ///< takes precedence over mass
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  ///< of a body with a mass
  double friction = 0.3, restitution = 0.0;
};

/// Rigid bodies, their joints and contacts. One substep is
///   begin_step(h)   kinematic velocities, impacts, half of gravity, contacts found
///   solve()         impulses so that joints and contacts hold at the predicted poses (SHAKE)
///   end_step()      poses move, unless move() has done so, the other half of gravity, impulses so that
///                   velocities agree (RATTLE)
/// Between begin and end anybody may apply impulses, ask for predicted poses and solve again: that is how
/// deformable bodies take part. Deterministic, single-threaded, no allocation once warm.
class RigidWorld {
 public:
  RigidWorld();
  ~RigidWorld();
  RigidWorld(RigidWorld&&) noexcept;
  RigidWorld& operator=(RigidWorld&&) noexcept;

  /// Bodies are numbered from 0 in the order in which they are added. Both throw invalid_argument.
  int add_body(const RigidBodyDesc& desc);
  void add_joint(const JointDesc& desc);
  void set_gravity(const Vec3& gravity);

  /// A whole step of its own, in as many substeps as substeps_for asks for, or more: how many.
  int step(double h);
  /// Substeps of h that joints need: the bodies that they hold turn by at most 0.15 radians in each, and the
  /// vibration of taut chains is resolved.
  int substeps_for(double h) const;
  void begin_step(double h);
  void solve();
  void move();
  void end_step();
  /// Poses, velocities and time of now, and back to them, so that a step can be taken again.
  void keep_start();
  void restore_start();

  int size() const;
  const CollisionShape& shape(int body) const;
  double friction(int body) const;
  double restitution(int body) const;
  bool dynamic(int body) const;   ///< has a finite mass
  bool immobile(int body) const;  ///< neither a mass nor a motion
  bool jointed(int body) const;   ///< some joint holds it
  const RigidBodyState& state(int body) const;
  const Pose& pose(int body) const { return state(body).pose; }
  /// Where the step under way will leave the body at its present velocity; its pose outside of a step.
  Pose predicted_pose(int body) const;
  /// Velocity of the body's material at a world point, kinematic bodies included.
  Vec3 velocity_at(int body, const Vec3& point) const;
  Eigen::Matrix3d inverse_mass_at(int body, const Vec3& point) const;  ///< zero unless dynamic
  /// Within a step, after solve(): how the body's predicted pose answers to a small wrench about its centre
  /// of mass, held by the joints and the contacts that press as it is; m and radians per kg m of h·impulse.
  Eigen::Matrix<double, 6, 6> compliance(int body) const;
  /// Appends the pairs of bodies that joints hold, or contacts in this step.
  void list_pairs(std::vector<std::pair<int, int>>& pairs) const;
  void apply_impulse(int body, const Vec3& point, const Vec3& impulse);
  /// An impulse (kg m/s) with its moment about a point of the world, whatever the body's pose is now.
  void apply_wrench(int body, const Vec3& about, const Vec3& impulse, const Vec3& moment);

  /// Within a step: the body answers as though it carried that mass as well, until the next call or
  /// put_down(), which makes up for what it was given in the meantime: no momentum is lost. That is how what
  /// presses on it in turn finds a balance, however light it is.
  void carry(int body, double mass);
  void put_down();

  /// A body without mass goes to the pose within the given time from now, or at once when it is 0.
  void move_body(int body, const Pose& pose, double duration);

  double time() const;
  /// Goes on from another time: bodies without mass stand where their motions have them then.
  void set_time(double seconds);
  /// Pose and velocities for a body with a mass, whatever its own.
  void set_state(int body, const RigidBodyState& state);
  double kinetic_energy() const;  ///< of the dynamic bodies, as all totals
  double gravity_energy() const;  ///< −Σ m g·x
  Vec3 linear_momentum() const;
  Vec3 angular_momentum() const;  ///< about the world's origin
  const RigidMetrics& metrics() const;
  /// Of the bodies and their shapes.
  std::int64_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isochor
