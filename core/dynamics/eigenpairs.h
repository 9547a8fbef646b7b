#pragma once
#include <Eigen/Core>

namespace isochor {

/// Values in ascending order, vectors in columns. Apart from their uses, since Eigen's solvers take long to
/// compile.
struct Eigenpairs {
  Eigen::MatrixXd vectors;
  Eigen::VectorXd values;
};

/// Of a symmetric matrix: K v = λ v, VᵀV = 1.
Eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd& k);

/// K v = λ G v, VᵀGV = 1; both symmetric, G positive definite.
Eigenpairs generalized_eigenpairs(const Eigen::MatrixXd& k, const Eigen::MatrixXd& g);

}  // namespace isochor
