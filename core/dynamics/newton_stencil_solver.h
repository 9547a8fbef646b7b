#pragma once
#include <optional>
#include <span>

#include "core/dynamics/newton_checkerboards.h"
#include "core/dynamics/newton_fast_diagonalization.h"

namespace isochor::newton {

/// A rigid body's part of J W J₀ᵀ, (JB) W₆ (J₀B)ᵀ: for each cell that touches a carried particle its rows of
/// JB and J₀B.
struct CarrierRows {
  using Vector = Eigen::Matrix<float, 6, 1>;
  struct Row {
    std::int32_t slot;
    Vector pull;
  };
  std::vector<Row> own, start;
  Eigen::Matrix<float, 6, 6> inverse_mass;
};

/// Solves J W J₀ᵀ μ = b in float by conjugate residuals, as a 27-point stencil over the lattice. The matrix
/// is as unsymmetric as the gradients have turned since the start of the step: each direction is made
/// orthogonal to the last few (truncated GCR [Eisenstat, Elman & Schultz 1983]; with a symmetric matrix one
/// would do). Preconditioned by fast diagonalisation on the bounding box where that pays, else by the
/// diagonal and checkerboards; by the diagonal alone beyond 256 cells an axis.
class StencilSolver {
 public:
  explicit StencilSolver(const LatticeLayout& layout);

  const Stencil& stencil() const { return stencil_; }
  /// Adds to the entry of a cell and itself or a neighbour.
  void add(std::int32_t cell, std::int32_t neighbor, float value);
  std::vector<CarrierRows>& carriers() { return carriers_; }
  /// To be called when the stencil has changed. areas: of the mean cell's faces, squared.
  void prepare(const std::array<double, 3>& areas);
  /// Keeps the preconditioner that is cheaper for the stencil prepared and these errors. Flat faces make
  /// modes that only the box's inverse reaches; in round or thin bodies it costs more than it saves.
  void choose_preconditioner(const double* errors);
  /// Solves for −errors until the largest residual is below tolerance times the first one. Cells without a
  /// row stay zero. Returns the iterations.
  int solve(const double* errors, double tolerance, int most_iterations = 3000);
  const float* solution() const { return solution_.data(); }
  std::int64_t bytes() const;

 private:
  double cost_of_iteration() const;
  void set_box_diagonal();
  void set_scale();
  /// Sums over a slab, to be added in their order.
  struct Partial {
    double with_earlier[depth] = {};
    Products products{};
    float worst = 0.0F;
  };
  Direction direction(int i) const;
  struct Start {
    float worst;
    double square;
  };
  Start start(const double* errors);
  Products sum_products() const;
  void apply(const EarlierDirections& earlier, float* image, double* products);
  void apply_carriers(const EarlierDirections& earlier, float* image, double* products);
  template <class Before, class After>
  void invert_box(const Before& before, const float* residual, float* to, const After& after);
  CheckerboardHeights heights() const;
  Products precondition(const EarlierDirections& earlier, const float* factors, const Direction& direction);
  float advance(float alpha, const Direction& direction);
  float worst_partial() const;

  const LatticeLayout& layout_;
  Stencil stencil_{};
  std::vector<CarrierRows> carriers_;
  std::optional<FastDiagonalization> box_;
  std::optional<Checkerboards> checkerboards_;  ///< without a box
  AlignedArray<float> entries_, solution_, residual_, scaled_, z_;
  std::vector<Partial> partial_;
  bool reached_ = false;  ///< the last solution its tolerance
  std::array<std::array<AlignedArray<float>, 3>, depth + 1> directions_;
  AlignedArray<float> box_diagonal_;  ///< less beneath the body's faces; 1 without a box
  AlignedArray<float> scale_;         ///< √(diagonal of the box / diagonal), or √(1/diagonal)
};

}  // namespace isochor::newton
