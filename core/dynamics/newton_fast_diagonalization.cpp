#include "core/dynamics/newton_fast_diagonalization.h"

#include <Eigen/Eigenvalues>

#include "core/parallel/parallel.h"

namespace isochor::newton {
namespace {

/// Parts that depend on the count only.
constexpr std::int64_t parts = 8;

}  // namespace

FastDiagonalization::FastDiagonalization(const LatticeLayout& layout)
    : parallel_(layout.slabs.size() >= LatticeLayout::fewest_parallel_slabs),
      size_(layout.size),
      strides_(layout.strides),
      origin_(layout.origin),
      row_((layout.size[0] + chunk - 1) / chunk * chunk),
      axes_{make_axis(size_[0], row_), make_axis(size_[1], size_[1]), make_axis(size_[2], size_[2])} {
  const std::int64_t count = std::int64_t{row_} * size_[1] * size_[2];
  for (auto* array : {&inverse_eigenvalues_, &values_, &scratch_}) *array = AlignedArray<float>(count);
  set_areas({1.0, 1.0, 1.0});
}

FastDiagonalization::Axis FastDiagonalization::make_axis(int cells, int row) {
  Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(cells, cells + 1), mean = difference;
  for (int i = 0; i < cells; ++i) {
    difference(i, i) = -1.0;
    difference(i, i + 1) = 1.0;
    mean(i, i) = mean(i, i + 1) = 0.5;
  }
  // A node at the end has half of the mass.
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(cells + 1);
  weights[0] = weights[cells] = 2.0;
  const Eigen::MatrixXd k = difference * weights.asDiagonal() * difference.transpose();
  const Eigen::MatrixXd g = mean * weights.asDiagonal() * mean.transpose();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, g);

  Axis axis{AlignedArray<float>(std::int64_t{cells} * row),
            AlignedArray<float>(std::int64_t{cells} * row),
            {},
            {},
            {}};
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      axis.modes[std::int64_t{i} * row + j] = static_cast<float>(solver.eigenvectors()(i, j));
      axis.transposed[std::int64_t{j} * row + i] = static_cast<float>(solver.eigenvectors()(i, j));
    }
    axis.eigenvalues.push_back(solver.eigenvalues()[i]);
    axis.stiffness.push_back(k(i, i));
    axis.mean.push_back(g(i, i));
  }
  return axis;
}

void FastDiagonalization::set_areas(const std::array<double, 3>& alpha) {
  if (alpha == alpha_) return;
  alpha_ = alpha;
  std::int64_t row = 0;
  for (int k = 0; k < size_[2]; ++k)
    for (int j = 0; j < size_[1]; ++j, row += row_) {
      const double rest = alpha[1] * axes_[1].eigenvalues[j] + alpha[2] * axes_[2].eigenvalues[k];
      for (int i = 0; i < size_[0]; ++i)
        inverse_eigenvalues_[row + i] = static_cast<float>(1.0 / (alpha[0] * axes_[0].eigenvalues[i] + rest));
    }
}

double FastDiagonalization::diagonal(int i, int j, int k) const {
  const auto& [x, y, z] = axes_;
  return x.stiffness[i] * y.mean[j] * z.mean[k] + x.mean[i] * y.stiffness[j] * z.mean[k] +
         x.mean[i] * y.mean[j] * z.stiffness[k];
}

void FastDiagonalization::forward(std::int64_t plane, const float* from) const {
  const std::int64_t rows = std::int64_t{row_} * size_[1];
  float *scratch = scratch_.data() + plane * rows, *values = values_.data() + plane * rows;
  const auto& kernels = stencil_kernels();
  kernels.multiply({from + origin_ + plane * strides_.plane, strides_.row, 1, axes_[0].modes.data(), row_,
                    scratch, row_, size_[1], row_, size_[0]});
  kernels.multiply(
      {axes_[1].transposed.data(), size_[1], 1, scratch, row_, values, row_, size_[1], row_, size_[1]});
}

void FastDiagonalization::backward(std::int64_t plane, float* to) const {
  const std::int64_t rows = std::int64_t{row_} * size_[1];
  float *scratch = scratch_.data() + plane * rows, *values = values_.data() + plane * rows;
  const auto& kernels = stencil_kernels();
  kernels.multiply(
      {axes_[1].modes.data(), size_[1], 1, values, row_, scratch, row_, size_[1], row_, size_[1]});
  kernels.multiply(
      {scratch, row_, 1, axes_[0].transposed.data(), row_, values, row_, size_[1], row_, size_[0]});
  float* target = to + origin_ + plane * strides_.plane;
  for (int j = 0; j < size_[1]; ++j)
    std::copy_n(values + std::int64_t{j} * row_, size_[0], target + j * strides_.row);
}

template <class Body>
void FastDiagonalization::for_work(std::int64_t count, const Body& body) const {
  if (parallel_)
    parallel_for(count, (count + parts - 1) / parts, body);
  else
    body(0, count);
}

void FastDiagonalization::apply(const float* from, float* to) const {
  const std::int64_t columns = std::int64_t{row_} * size_[1];
  for_work(size_[2], [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t plane = begin; plane < end; ++plane) forward(plane, from);
  });
  for_work(columns / chunk, [&](std::int64_t begin, std::int64_t end) {
    const std::int64_t first = begin * chunk, count = (end - begin) * chunk;
    stencil_kernels().solve_columns({axes_[2].transposed.data(), axes_[2].modes.data(),
                                     inverse_eigenvalues_.data() + first, values_.data() + first, columns,
                                     size_[2], static_cast<int>(count)});
  });
  for_work(size_[2], [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t plane = begin; plane < end; ++plane) backward(plane, to);
  });
}

double FastDiagonalization::products() const {
  return 2.0 * (size_[0] + size_[1] + size_[2]) * static_cast<double>(values_.size());
}

std::int64_t FastDiagonalization::bytes() const {
  std::int64_t result = inverse_eigenvalues_.bytes() + values_.bytes() + scratch_.bytes();
  for (const Axis& axis : axes_) result += axis.modes.bytes() + axis.transposed.bytes();
  return result;
}

}  // namespace isochor::newton
