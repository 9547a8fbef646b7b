#pragma once
#include <Eigen/Core>
#include <array>

#include "core/dynamics/newton_array.h"

namespace isochor {

/// z = (V⊗V⊗V) diag(d) (V⊗V⊗V)ᵀ r over a box of values in lattice order, x fastest: an operator that is
/// diagonal in the modes of its three axes, applied in float by small matrix products [Lynch, Rice & Thomas
/// 1964].
class BoxTransform {
 public:
  /// modes: the columns of V, one matrix an axis.
  explicit BoxTransform(const std::array<Eigen::MatrixXd, 3>& modes);

  std::int64_t size() const { return std::int64_t{size_[0]} * size_[1] * size_[2]; }
  int size(int axis) const { return size_[axis]; }
  /// d of the mode (i, j, k), to be written.
  float& weight(int i, int j, int k) { return weights_[(std::int64_t{k} * size_[1] + j) * row_ + i]; }
  /// values: size() of them, replaced by the product.
  void apply(float* values) const;
  std::int64_t bytes() const;

 private:
  struct Axis {
    newton::AlignedArray<float> modes, transposed;  ///< rows padded where they are the right factor
  };

  std::array<int, 3> size_;
  int row_;  ///< size_[0] rounded up to whole chunks
  std::array<Axis, 3> axes_;
  newton::AlignedArray<float> weights_, planes_, scratch_;
};

}  // namespace isochor
