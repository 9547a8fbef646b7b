#pragma once
#include "core/dynamics/soft_body.h"
#include "core/dynamics/spring_tangent.h"

namespace isochor {

/// Solves (M + T)·u = r, T = aK + bC (SpringTangent), u zero where particles are pinned: conjugate gradients
/// in double, filtered [Baraff & Witkin 1998], preconditioned by the diagonal blocks and exactly on the six
/// rigid modes, whose stiffness is M alone and may be 1e-10 of the rest.
class ImplicitSolver {
 public:
  explicit ImplicitSolver(const SoftBody& body);

  /// Takes T at the body's positions.
  void linearize(const SoftBody& body, double stiffness_weight, double damping_weight);
  /// displacement += u with r = weight·forces − T·displacement. tolerance: of the residual in the
  /// preconditioner's norm, relative. Returns the iterations.
  int advance(const SoftBody& body, double weight, const Coordinates& forces, Coordinates& displacement,
              double tolerance, int max_iterations);

  std::int64_t bytes() const;

 private:
  using Vec6 = Eigen::Matrix<double, 6, 1>;

  void filter(const SoftBody& body, Coordinates& v) const;
  void multiply(const SoftBody& body, const Coordinates& p, Coordinates& product) const;
  void build_coarse(const SoftBody& body);
  void precondition(const SoftBody& body);
  int solve(const SoftBody& body, Coordinates& displacement, double tolerance, int max_iterations);
  void expand(const SoftBody& body, const Vec6& coefficients, Coordinates& v) const;
  Vec6 restrict_to_rigid(const Coordinates& v) const;

  SpringTangent tangent_;
  SpringTangent::Blocks inverse_blocks_;
  Eigen::Matrix<double, 6, 6> coarse_inverse_;
  Vec3 center_ = Vec3::Zero();
  Coordinates arms_;  ///< positions about the centre
  Coordinates residual_, preconditioned_, direction_, product_;
};

}  // namespace isochor
