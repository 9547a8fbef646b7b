#pragma once
#include <optional>
#include <span>

#include "core/dynamics/newton_fast_diagonalization.h"

namespace isochor::newton {

/// A rigid body's part of J W Jᵀ, (JB) W₆ (JB)ᵀ: for each cell that touches a carried particle its row of JB.
struct CarrierRows {
  struct Row {
    std::int32_t slot;
    Eigen::Matrix<float, 6, 1> pull;
  };
  std::vector<Row> rows;
  Eigen::Matrix<float, 6, 6> inverse_mass;
};

/// Conjugate gradients in float on a 27-point stencil over the lattice, preconditioned by fast
/// diagonalisation on the bounding box where that pays, else by the diagonal.
class StencilSolver {
 public:
  /// weights: of a cell's residual where the largest is looked for.
  StencilSolver(const LatticeLayout& layout, const AlignedArray<float>& weights);

  const Stencil& stencil() const { return stencil_; }
  /// Adds to the entry of two cells that are the same or neighbours.
  void add(std::int32_t a, std::int32_t b, float value);
  std::vector<CarrierRows>& carriers() { return carriers_; }
  /// To be called when the stencil has changed. areas: of the mean cell's faces, squared.
  void prepare(const std::array<double, 3>& areas);
  /// Solves for the right side until the largest weighted residual is below tolerance times the first one.
  /// Cells without a row stay zero. Returns the iterations.
  int solve(double tolerance);

  float* right_side() { return residual_.data(); }  ///< lost by the solution
  const float* solution() const { return solution_.data(); }
  std::int64_t bytes() const;

 private:
  struct Progress {
    double product = 0.0;  ///< residual·z
    float worst = 0.0F;
  };
  double apply();
  Progress advance(float alpha);
  void turn(float beta);
  double apply_carriers();

  const LatticeLayout& layout_;
  const AlignedArray<float>& weights_;
  Stencil stencil_{};
  std::vector<CarrierRows> carriers_;
  std::optional<FastDiagonalization> box_;
  AlignedArray<float> entries_, solution_, residual_, scaled_, z_, search_, image_;
  AlignedArray<float> box_diagonal_;
  AlignedArray<float> scale_;  ///< with box_: √(diagonal of the box / diagonal), else 1/diagonal
};

}  // namespace isochor::newton
