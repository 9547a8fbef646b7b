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
  /// The inverse in three parts: all planes forward, the columns across them, all planes backward. From and
  /// to the layout's slots; reads zero where there is no cell.
  void forward(const LatticeLayout::Slab& slab, const float* from) const;
  void solve_columns() const;
  void backward(const LatticeLayout::Slab& slab, float* to) const;
  double products() const;  ///< multiplications of the three
  std::int64_t bytes() const;

 private:
  struct Axis {
    AlignedArray<float> backward, forward;             ///< V and Vᵀ, or halves of them (Modes)
    std::vector<double> eigenvalues, stiffness, mean;  ///< λ, diagonals of K and G
    bool mirrored = false;
    Modes modes() const;
  };
  static Axis make_axis(const std::vector<double>& weights, int row);
  void forward_plane(std::int64_t plane, const float* from) const;
  void backward_plane(std::int64_t plane, float* to) const;

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
