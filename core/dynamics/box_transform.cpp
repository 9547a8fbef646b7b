#include "core/dynamics/box_transform.h"

#include "core/dynamics/newton_kernels.h"

namespace isochor {

using newton::stencil_kernels;

BoxTransform::BoxTransform(const std::array<Eigen::MatrixXd, 3>& modes) {
  for (int axis = 0; axis < 3; ++axis) size_[axis] = static_cast<int>(modes[axis].rows());
  row_ = (size_[0] + newton::chunk - 1) / newton::chunk * newton::chunk;
  for (int axis = 0; axis < 3; ++axis) {
    const int size = size_[axis], row = axis == 0 ? row_ : size;
    auto& [forward, backward] = axes_[axis];
    forward = newton::AlignedArray<float>(std::int64_t{size} * row);
    backward = newton::AlignedArray<float>(std::int64_t{size} * row);
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) {
        forward[std::int64_t{i} * row + j] = static_cast<float>(modes[axis](i, j));
        backward[std::int64_t{j} * row + i] = static_cast<float>(modes[axis](i, j));
      }
    }
  }
  for (auto* array : {&weights_, &planes_, &scratch_})
    *array = newton::AlignedArray<float>(std::int64_t{row_} * size_[1] * size_[2]);
}

void BoxTransform::apply(float* values) const {
  const auto& kernels = stencil_kernels();
  const auto [nx, ny, nz] = size_;
  const std::int64_t plane = std::int64_t{row_} * ny;
  float *a = planes_.data(), *b = scratch_.data();
  kernels.multiply({values, nx, 1, axes_[0].modes.data(), row_, a, row_, ny * nz, row_, nx});
  const auto modes = [&](int axis) {
    return newton::Modes{axes_[axis].transposed.data(), axes_[axis].modes.data(), size_[axis], false};
  };
  for (int k = 0; k < nz; ++k) kernels.to_modes({modes(1), a + k * plane, row_, b + k * plane, row_, row_});
  kernels.solve_columns({modes(2), weights_.data(), b, plane, static_cast<int>(plane)});
  for (int k = 0; k < nz; ++k) kernels.from_modes({modes(1), b + k * plane, row_, a + k * plane, row_, row_});
  kernels.multiply({a, row_, 1, axes_[0].transposed.data(), row_, b, row_, ny * nz, row_, nx});
  for (std::int64_t row = 0; row < std::int64_t{ny} * nz; ++row)
    std::copy_n(b + row * row_, nx, values + row * nx);
}

std::int64_t BoxTransform::bytes() const {
  std::int64_t result = weights_.bytes() + planes_.bytes() + scratch_.bytes();
  for (const Axis& axis : axes_) result += axis.modes.bytes() + axis.transposed.bytes();
  return result;
}

}  // namespace isochor
