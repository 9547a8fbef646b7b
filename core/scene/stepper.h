#pragma once
#include "core/common/progress.h"
#include "core/scene/energy_guard.h"

namespace isochor {

/// Steps a world. A substep is: half a kick by the forces, prediction, contacts and volume together,
/// velocities from positions, the other half of the kick (symplectic Euler, its velocities taken at the time
/// of the positions).
class Stepper {
 public:
  explicit Stepper(World& world);

  StepStats frame(double seconds, const Progress& progress);

 private:
  /// Bodies whose cells lack their volumes go there first.
  void start();
  /// Of the volumes at a frame's end.
  double asked_tolerance() const;
  /// Of the volumes after a substep of h that ends no frame.
  double tolerance_within_frame(double h) const;
  /// Where there are rigid bodies only.
  void advance_rigid(double h);
  /// In as many parts as the joints of rigid bodies ask for.
  void advance_jointed(double h);
  /// Rigid bodies go first: their impacts, joints and contacts among themselves.
  void start_rigid(double h);
  /// Halves the substep while a tet inverts or an implicit solve fails, at most 5 times. Tets that invert
  /// even so halt the body, or are left to recovery at the end: lifts that never ended have thrown what is a
  /// million times heavier. What a substep of a frame needed, the next one begins with, and one less after
  /// each that needed no more.
  void advance(double h, int halvings);
  void advance_halves(double h, int halvings);
  /// Back to the start of the substep, and to the frame's figures before it.
  void take_back(const StepStats& before);
  void predict(const Substep& step, SceneSoftBody& soft);
  void move_freely(const Substep& step, SceneSoftBody& soft);
  void take_velocities(const Substep& step, SceneSoftBody& soft);
  void finish(const Substep& step, std::size_t index);
  /// A filtered substep that touches something, or ends with more energy than the ledger allows, is taken
  /// back and stepped by implicit Euler, which gains none. True when it stands, and is finished.
  bool settle(const Substep& step, SceneSoftBody& soft);
  void remember_contacts();
  void count_contacts();

  World& world_;
  EnergyGuard guard_;
  double tolerance_ = 0.0;  ///< of the present substep's volumes
  int begin_at_ = 0;        ///< halvings that tets needed lately: substeps begin with them
  int deepest_ = 0;         ///< halvings for tets within the present substep
  bool together_ = false;   ///< no body is stepped by itself
  bool lifting_ = true;     ///< tets that invert are lifted within the substep
  StepStats stats_;
};

}  // namespace isochor
