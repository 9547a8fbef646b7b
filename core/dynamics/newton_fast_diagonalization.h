#pragma once
#include <array>

#include "core/dynamics/newton_array.h"
#include "core/dynamics/newton_lattice.h"

namespace isochor::newton {

/// The inverse of J W Jᵀ of a full box at rest, by fast diagonalisation [Lynch, Rice & Thomas 1964]. With D
/// and S the difference and mean of an axis' neighbouring nodes, W the lumped inverse masses of that axis,
/// K = D W Dᵀ and G = S W Sᵀ, the operator is α_x K⊗G⊗G + α_y G⊗K⊗G + α_z G⊗G⊗K (nodes of either parity taken
/// alike, which leaves a condition number of two). From K v = λ G v and VᵀGV = 1 its inverse is
/// (V⊗V⊗V) diag(1/Σα_dλ_d) (V⊗V⊗V)ᵀ. Checkerboards, its near-null modes, are inverted like all others. In a
/// body of another shape W is the product nearest to its own inverse masses.
class FastDiagonalization {
 public:
  static constexpr int longest = 256;  ///< cells an axis

  explicit FastDiagonalization(const LatticeLayout& layout);

  /// α: squared areas of the mean cell's faces.
  void set_areas(const std::array<double, 3>& alpha);
  /// Of the operator for α = 1.
  double diagonal(int i, int j, int k) const;
  /// From and to the layout's slots; reads zero where there is no cell.
  void apply(const float* from, float* to) const;
  double products() const;  ///< multiplications of apply
  std::int64_t bytes() const;

 private:
  struct Axis {
    AlignedArray<float> modes, transposed;  ///< V and Vᵀ, rows padded where they are the right factor
    std::vector<double> eigenvalues, stiffness, mean;  ///< λ, diagonals of K and G
  };
  static Axis make_axis(const std::vector<double>& weights, int row);
  void forward(std::int64_t plane, const float* from) const;
  void backward(std::int64_t plane, float* to) const;

  template <class Body>
  void for_work(std::int64_t count, const Body& body) const;

  bool parallel_;
  std::array<int, 3> size_;
  Strides strides_;
  std::int64_t origin_;
  int row_;  ///< size_[0] rounded up to whole chunks
  std::array<Axis, 3> axes_;
  AlignedArray<float> inverse_eigenvalues_, values_, scratch_;  ///< planes of size_[1] rows
  std::array<double, 3> alpha_{};
};

}  // namespace isochor::newton
