#pragma once
#include "core/dynamics/implicit_solver.h"
#include "core/dynamics/rigid_part.h"

namespace isochor {

/// Springs stepped at any stiffness, by one linear solve a step, in the frame that turns with the body: R is
/// its rigid motion over the step, v = v_rigid + d. Turned, so that a stiff body that spins does not grow
/// (straight paths stretch it by (hω)²/2). Two schemes:
/// - linearly implicit Euler [Baraff & Witkin 1998], which eats the energy of what it does not resolve,
///     x̂ = R(x + h·d + u),  (M + h²K + hC)·u = h²(f(x) − (hK + C)·d);
/// - filtered leapfrog, which keeps it: the kicks of symplectic Euler by M(M + h²K/4 + hC/2)⁻¹f in place of
/// f,
///   so that no frequency is above 2/h. With K constant these are the positions of the trapezoidal rule.
class ImplicitStep {
 public:
  explicit ImplicitStep(const SoftBody& body);

  /// Takes the body from the start of the substep to x̂. Linear and angular momentum are kept to round-off
  /// unless particles are pinned.
  void predict(SoftBody& body, double h);
  /// body.forces, those of its positions, become the filtered ones.
  void filter(SoftBody& body, double h);
  /// Takes the body, kicked already, to R(x + h·d).
  void drift(SoftBody& body, double h);
  /// Velocities of the end positions: (x − x_start)/h, turned with the body.
  void finish(SoftBody& body, double h);

  std::int64_t bytes() const;

 private:
  RigidPart split_velocities(const SoftBody& body, double h);
  void turn(SoftBody& body, const RigidPart& motion, double h);
  void restore_momentum(SoftBody& body, const Vec3& center, double h);

  ImplicitSolver solver_;
  Coordinates displacement_, force_;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
};

}  // namespace isochor
