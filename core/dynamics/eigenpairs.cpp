#include "core/dynamics/eigenpairs.h"

#include <Eigen/Eigenvalues>

namespace isochor {

Eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd& k) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(k);
  return {solver.eigenvectors(), solver.eigenvalues()};
}

Eigenpairs generalized_eigenpairs(const Eigen::MatrixXd& k, const Eigen::MatrixXd& g) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, g);
  return {solver.eigenvectors(), solver.eigenvalues()};
}

}  // namespace isochor
