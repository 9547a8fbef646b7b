#pragma once
#include "core/dynamics/implicit_solver.h"
#include "core/dynamics/rigid_part.h"

namespace isochor {

/// Springs stepped at any stiffness, by one linear solve a step [Baraff & Witkin 1998], in the frame that
/// turns with the body: R is its rigid motion over the step, v = v_rigid + d, and
///   x̂ = R(x + h·d + u),  (M + h²K + hC)·u = h²(f(x) − (hK + C)·d).
/// Turned, so that a stiff body that spins does not grow (straight paths stretch it by (hω)²/2).
class ImplicitStep {
 public:
  explicit ImplicitStep(const SoftBody& body);

  /// Takes the body from the start of the substep to x̂. Linear and angular momentum are kept to round-off
  /// unless particles are pinned.
  void predict(SoftBody& body, double h);
  /// Velocities of the end positions: (x − x_start)/h, turned with the body.
  void finish(SoftBody& body, double h);

  std::int64_t bytes() const;

 private:
  void turn(SoftBody& body, const RigidPart& motion);
  void restore_momentum(SoftBody& body, const Vec3& center, double h);

  ImplicitSolver solver_;
  Coordinates displacement_, force_;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
};

}  // namespace isochor
