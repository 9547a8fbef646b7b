#pragma once
#include <span>
#include <vector>

#include "core/common/disjoint_sets.h"
#include "core/rigid/joint.h"
#include "core/rigid/rigid_metrics.h"
#include "core/rigid/step_contacts.h"

namespace isochor {

/// Both stages of a step over joints and contacts: SHAKE for the poses at its end, RATTLE for the velocities
/// there [Andersen 1983], by impulses [Bender & Schmitt 2006].
class StepSolver {
 public:
  void add_joint(const RigidJoint& joint);
  /// Impacts, the first half of gravity, contacts, and last step's impulses as a start.
  void begin(std::span<BodyRecord> bodies, const Vec3& gravity, double h);
  /// Newton's method over the errors that the predicted poses would have.
  void solve_positions(std::span<BodyRecord> bodies);
  /// At the poses of the step's end: joints at rest relative to each other, contacts not closing, or parting
  /// with the restitution times the speed at which they met.
  void solve_velocities(std::span<BodyRecord> bodies);
  /// Bodies have other masses than at begin().
  void weigh(std::span<const BodyRecord> bodies);
  /// After solve_positions: see RigidWorld::compliance.
  Eigen::Matrix<double, 6, 6> compliance(int body);
  /// Substeps a second that the joints need.
  double fastest_rate(std::span<const BodyRecord> bodies) const;
  /// Appends the pairs of bodies that joints hold, or contacts in this step.
  void list_pairs(std::vector<BodyPair>& pairs) const;
  const RigidMetrics& metrics() const { return metrics_; }

 private:
  void load_bodies(std::span<const BodyRecord> bodies, double part);
  void give_impulses(std::span<BodyRecord> bodies);
  void apply_gathered(std::span<BodyRecord> bodies);
  void predict(std::span<const BodyRecord> bodies);
  void build_rows(std::span<const BodyRecord> bodies);
  void position_residuals(std::span<const BodyRecord> bodies);
  void velocity_residuals(std::span<const BodyRecord> bodies);
  void add_contact_rows(const RigidContact& contact, std::span<const BodyRecord> bodies);
  enum class Stage { positions, velocities };
  double violation(std::span<const BodyRecord> bodies, Stage stage);
  void warm_start(std::span<BodyRecord> bodies, Stage stage);
  void newton(std::span<BodyRecord> bodies, Stage stage);
  void remember(std::span<const BodyRecord> bodies);
  void recall(std::span<BodyRecord> bodies);
  double iterate(std::span<BodyRecord> bodies, Stage stage);
  void give_up_worst(std::span<BodyRecord> bodies, Stage stage);
  void find_groups(std::span<const BodyRecord> bodies);
  int group_of(int a, int b, std::span<const BodyRecord> bodies) const;
  int group_of(const ConstraintBlock& block, std::span<const BodyRecord> bodies) const;
  bool any_lost(int a, int b) const {
    return lost_[static_cast<std::size_t>(a)] || lost_[static_cast<std::size_t>(b)];
  }
  void limit_energy(std::span<BodyRecord> bodies, int group);
  void keep_impulses(std::vector<double>& impulses) const;
  static void keep_velocities(std::span<const BodyRecord> bodies,
                              std::vector<std::array<Vec3, 2>>& velocities);
  void store_impulses();
  void measure(std::span<const BodyRecord> bodies);

  std::vector<RigidJoint> joints_;
  std::vector<BodyPair> jointed_;  ///< sorted
  StepContacts found_;
  ConstraintSet set_;
  ImpulseSolver solver_;
  std::vector<SolverBody> solver_bodies_;
  std::vector<Pose> predicted_;
  std::vector<std::array<Vec3, 2>> entry_, best_velocities_;  ///< with angular momenta
  std::vector<double> entry_impulses_, best_impulses_, last_impulses_;
  DisjointSets groups_;             ///< of bodies that rows connect
  std::vector<std::uint8_t> lost_;  ///< bodies that this step has given up, or the last one had
  RigidMetrics metrics_;
  double h_ = 0.0, last_h_ = 0.0;
};

}  // namespace isochor
