#pragma once
#include "core/scene/contact_groups.h"
#include "core/scene/substep.h"

namespace isochor {

/// Judges substeps by the energy of bodies that press on each other, all of a group together: never more than
/// at the start of the substep and what surfaces that move have put in, beyond the swing of symplectic steps.
/// What is too much is taken from the velocities, and with it no momentum that the group has for itself:
/// first from deformations, then from all that differs from the group's common motion. A substep of no use,
/// that ends inverted, with bodies in each other, or with more energy in the springs alone, is taken back,
/// and the group carried along as it stands, with its momentum, in half of its inner motion: what was apart
/// and valid stays so.
class EnergyGuard {
 public:
  explicit EnergyGuard(World& world) : world_(world) {}

  /// A substep begins.
  void begin();
  /// Its contacts are known, and its velocities but for the last half kick.
  void find_groups() { groups_.find(world_); }
  /// The body's group can be taken back.
  bool can_halt(std::size_t soft) const;
  /// At the substep's end.
  void hold(const Substep& step);

 private:
  struct Sums {
    double mass = 0.0, kinetic = 0.0, potential = 0.0;
    Vec3 center = Vec3::Zero(), momentum = Vec3::Zero();
    /// About the world's origin, kg m² and kg m²/s; of deformable bodies where asked for.
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Vec3 angular_momentum = Vec3::Zero();

    void add_soft(const SoftBody& body, const Coordinates& x, const Coordinates& v);
    void add_turning(const SoftBody& body, const Coordinates& x, const Coordinates& v);
    void add_rigid(const RigidBodyState& state);
    RigidPart common_motion() const;
  };
  enum class At { start, end };
  /// How a halted group goes on: its place, and its motion at the start.
  struct Carriage {
    Pose from, to;
    RigidPart motion;
    Vec3 gained = Vec3::Zero();  ///< of velocity
  };

  template <class Visit>
  void for_soft(int group, const Visit& visit) const;
  template <class Visit>
  void for_rigid(int group, const Visit& visit) const;
  bool is_in_contact(const SceneSoftBody& soft) const;
  /// At which surfaces that it comes out of move it, 0 where it does not, and what they have done on it.
  double emerging_speed(int group) const;
  double emerging_work(int group) const;
  bool can_halt_group(int group) const;
  bool has_no_room(const Substep& step, int group, bool feasible) const;
  Sums sum(int group, At when, bool turning) const;
  double spring_energy_at(SceneSoftBody& soft, At when) const;
  double work_of_anchor(const Substep& step, int group, const Sums& start, const Sums& end) const;
  double judge(const Substep& step, int group);
  double slow_down(int group, double excess);
  double slow_down_about(const RigidPart& motion, int group, double excess);
  void halt(const Substep& step, int group);
  /// The group's own, or that of a surface that would come into it and finds nothing behind.
  Carriage best_carriage(const Substep& step, int group);
  Carriage own_carriage(const Substep& step, int group) const;
  Carriage carriage_of(int anchor) const;
  void carry_along(const Carriage& carriage, int group);
  bool is_entered(int group) const;

  World& world_;
  ContactGroups groups_;
  std::vector<RigidBodyState> rigid_start_;
};

}  // namespace isochor
