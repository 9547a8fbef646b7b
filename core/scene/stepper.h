#pragma once
#include "core/common/progress.h"
#include "core/scene/world.h"

namespace isochor {

/// Steps a world. A substep is: forces, prediction, contacts and volume together, velocities from positions.
class Stepper {
 public:
  explicit Stepper(World& world) : world_(world) {}

  StepStats frame(double seconds, const Progress& progress);

 private:
  /// Halves the substep while a tet inverts, at most 5 times; then the recovery.
  void advance(double h, int halvings);
  void predict_all(double h);
  void add_forces(SoftBody& body);
  void constrain(SceneSoftBody& soft, double h);
  ProjectionResult project(SceneSoftBody& soft);
  void follow_pins(SceneSoftBody& soft);
  void follow_grab(SceneSoftBody& soft, double h);
  void finish_velocities(SceneSoftBody& soft, double h);
  void recover(SceneSoftBody& soft);
  void record(const SceneSoftBody& soft, const ProjectionResult& result);

  World& world_;
  StepStats stats_;
};

}  // namespace isochor
