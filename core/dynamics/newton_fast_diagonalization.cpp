#include "core/dynamics/newton_fast_diagonalization.h"

#include <algorithm>
#include <cmath>

#include "core/dynamics/eigenpairs.h"
#include "core/parallel/parallel.h"

namespace isochor::newton {
namespace {

/// Parts that depend on the count only.
constexpr std::int64_t parts = 8;

/// Inverse mass of a node outside the body, over that of one inside. Light, so that the box gives way there
/// almost as nothing would; heavy as the body, it would halt every mode that reaches the surface.
constexpr double outside_weight = 1e4;
/// What a node inside counts in the fit, over one outside.
constexpr double inside_counts = 5.0;
constexpr int fit_rounds = 8;

/// log of the lumped inverse masses at the nodes of the box, and what each counts.
struct LogWeights {
  std::array<int, 3> nodes;
  std::vector<double> value, counts;

  template <class Visit>
  void for_nodes(const Visit& visit) const {
    std::size_t at = 0;
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j)
        for (int i = 0; i < nodes[0]; ++i, ++at) visit(std::array{i, j, k}, at);
  }
};

LogWeights log_weights(const LatticeLayout& layout) {
  std::vector<std::uint8_t> cells(layout.slots, 0);
  for (const std::int32_t cell : layout.cell_slots)
    for (int b = 0; b < 8; ++b) ++cells[cell + layout.corner_offset(b)];
  LogWeights result{{layout.size[0] + 1, layout.size[1] + 1, layout.size[2] + 1}, {}, {}};
  result.for_nodes([&](const std::array<int, 3>& node, std::size_t) {
    const int here =
        cells[layout.origin + node[0] + node[1] * layout.strides.row + node[2] * layout.strides.plane];
    result.value.push_back(std::log(here > 0 ? 8.0 / here : outside_weight));
    result.counts.push_back(here > 0 ? inside_counts : 1.0);
  });
  return result;
}

/// The product of a weight an axis that is nearest to the body's, in the least squares of the logarithms.
std::array<std::vector<double>, 3> separable_weights(const LatticeLayout& layout) {
  const LogWeights body = log_weights(layout);
  std::array<std::vector<double>, 3> log;
  for (int axis = 0; axis < 3; ++axis) log[axis].assign(body.nodes[axis], 0.0);
  for (int round = 0; round < fit_rounds; ++round)
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> sum(body.nodes[axis], 0.0), counts = sum;
      body.for_nodes([&](const std::array<int, 3>& node, std::size_t at) {
        const double others =
            log[(axis + 1) % 3][node[(axis + 1) % 3]] + log[(axis + 2) % 3][node[(axis + 2) % 3]];
        sum[node[axis]] += body.counts[at] * (body.value[at] - others);
        counts[node[axis]] += body.counts[at];
      });
      for (int i = 0; i < body.nodes[axis]; ++i) log[axis][i] = sum[i] / counts[i];
    }
  for (auto& axis : log)
    for (double& weight : axis) weight = std::exp(weight);
  return log;
}

}  // namespace

FastDiagonalization::FastDiagonalization(const LatticeLayout& layout)
    : parallel_(layout.slabs.size() >= LatticeLayout::fewest_parallel_slabs),
      size_(layout.size),
      strides_(layout.strides),
      origin_(layout.origin),
      row_((layout.size[0] + chunk - 1) / chunk * chunk) {
  const auto weights = separable_weights(layout);
  for (int axis = 0; axis < 3; ++axis) axes_[axis] = make_axis(weights[axis], axis == 0 ? row_ : 0);
  const std::int64_t count = std::int64_t{row_} * size_[1] * size_[2];
  for (auto* array : {&inverse_eigenvalues_, &values_, &scratch_}) *array = AlignedArray<float>(count);
  set_areas({1.0, 1.0, 1.0});
}

namespace {

/// Those of K v = λ G v for vectors v = basis·u.
Eigenpairs solve_within(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& k, const Eigen::MatrixXd& g) {
  const Eigen::MatrixXd inside_k = basis.transpose() * k * basis, inside_g = basis.transpose() * g * basis;
  const Eigenpairs inside = generalized_eigenpairs(inside_k, inside_g);
  return {basis * inside.vectors, inside.values};
}

/// Even vectors first, then odd ones.
Eigenpairs solve_mirrored(const Eigen::MatrixXd& k, const Eigen::MatrixXd& g) {
  const Eigen::Index size = k.rows(), odd = size / 2, even = size - odd;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(size, size), mirror = one.rowwise().reverse();
  const Eigenpairs evens = solve_within((0.5 * (one + mirror)).leftCols(even), k, g);
  if (odd == 0) return evens;
  const Eigenpairs odds = solve_within((0.5 * (one - mirror)).leftCols(odd), k, g);
  Eigenpairs result{Eigen::MatrixXd(size, size), Eigen::VectorXd(size)};
  result.vectors << evens.vectors, odds.vectors;
  result.values << evens.values, odds.values;
  return result;
}

bool is_mirrored(const std::vector<double>& weights) {
  constexpr double round_off = 1e-12;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (std::abs(weights[i] - weights[weights.size() - 1 - i]) > round_off * weights[i]) return false;
  return true;
}

}  // namespace

/// The first axis multiplies from the right, with whole rows; row: its length in memory, 0 of the others.
FastDiagonalization::Axis FastDiagonalization::make_axis(const std::vector<double>& weights, int row) {
  const int cells = static_cast<int>(weights.size()) - 1;
  Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(cells, cells + 1), mean = difference;
  for (int i = 0; i < cells; ++i) {
    difference(i, i) = -1.0;
    difference(i, i + 1) = 1.0;
    mean(i, i) = mean(i, i + 1) = 0.5;
  }
  const Eigen::VectorXd w = Eigen::Map<const Eigen::VectorXd>(weights.data(), cells + 1);
  const Eigen::MatrixXd k = difference * w.asDiagonal() * difference.transpose();
  const Eigen::MatrixXd g = mean * w.asDiagonal() * mean.transpose();
  Axis axis;
  axis.mirrored = row == 0 && is_mirrored(weights);
  const Eigenpairs pairs =
      axis.mirrored ? solve_mirrored(k, g) : solve_within(Eigen::MatrixXd::Identity(cells, cells), k, g);
  for (int i = 0; i < cells; ++i) {
    axis.eigenvalues.push_back(pairs.values[i]);
    axis.stiffness.push_back(k(i, i));
    axis.mean.push_back(g(i, i));
  }
  const int stride = std::max(row, cells);
  axis.backward = AlignedArray<float>(std::int64_t{cells} * stride);
  axis.forward = AlignedArray<float>(std::int64_t{cells} * stride);
  const auto place = [&](int first, int count, std::int64_t offset, std::int64_t length) {
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) {
        const auto value = static_cast<float>(pairs.vectors(i, first + j));
        axis.backward[offset + i * length + j] = value;
        axis.forward[offset + j * length + i] = value;
      }
  };
  const int odd = axis.mirrored ? cells / 2 : 0, even = cells - odd;
  place(0, even, 0, axis.mirrored ? even : stride);
  place(even, odd, std::int64_t{even} * even, odd);
  return axis;
}

Modes FastDiagonalization::Axis::modes() const {
  return {forward.data(), backward.data(), static_cast<int>(eigenvalues.size()), mirrored};
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

void FastDiagonalization::forward_plane(std::int64_t plane, const float* from) const {
  const std::int64_t rows = std::int64_t{row_} * size_[1];
  float *scratch = scratch_.data() + plane * rows, *values = values_.data() + plane * rows;
  const auto& kernels = stencil_kernels();
  kernels.multiply({from + origin_ + plane * strides_.plane, strides_.row, 1, axes_[0].backward.data(), row_,
                    scratch, row_, size_[1], row_, size_[0]});
  kernels.to_modes({axes_[1].modes(), scratch, row_, values, row_, row_});
}

void FastDiagonalization::backward_plane(std::int64_t plane, float* to) const {
  const std::int64_t rows = std::int64_t{row_} * size_[1];
  float *scratch = scratch_.data() + plane * rows, *values = values_.data() + plane * rows;
  float* target = to + origin_ + plane * strides_.plane;
  const auto& kernels = stencil_kernels();
  kernels.from_modes({axes_[1].modes(), values, row_, scratch, row_, row_});
  const bool fits = size_[0] == row_;
  kernels.multiply({scratch, row_, 1, axes_[0].forward.data(), row_, fits ? target : values,
                    fits ? strides_.row : row_, size_[1], row_, size_[0]});
  if (fits) return;
  for (int j = 0; j < size_[1]; ++j)
    std::copy_n(values + std::int64_t{j} * row_, size_[0], target + j * strides_.row);
}

void FastDiagonalization::forward(const LatticeLayout::Slab& slab, const float* from) const {
  for (std::int64_t i = 0; i < slab.planes; ++i) forward_plane(slab.first_plane + i, from);
}

void FastDiagonalization::backward(const LatticeLayout::Slab& slab, float* to) const {
  for (std::int64_t i = 0; i < slab.planes; ++i) backward_plane(slab.first_plane + i, to);
}

void FastDiagonalization::solve_columns() const {
  const std::int64_t columns = std::int64_t{row_} * size_[1], blocks = columns / chunk;
  const auto solve = [&](std::int64_t begin, std::int64_t end) {
    const std::int64_t first = begin * chunk, count = (end - begin) * chunk;
    stencil_kernels().solve_columns({axes_[2].modes(), inverse_eigenvalues_.data() + first,
                                     values_.data() + first, columns, static_cast<int>(count)});
  };
  if (parallel_)
    parallel_for(blocks, (blocks + parts - 1) / parts, solve, Work::alike);
  else
    solve(0, blocks);
}

double FastDiagonalization::products() const {
  double products = size_[0];
  for (int axis = 1; axis < 3; ++axis) products += (axes_[axis].mirrored ? 0.5 : 1.0) * size_[axis];
  return 2.0 * products * static_cast<double>(values_.size());
}

std::int64_t FastDiagonalization::bytes() const {
  std::int64_t result = inverse_eigenvalues_.bytes() + values_.bytes() + scratch_.bytes();
  for (const Axis& axis : axes_) result += axis.backward.bytes() + axis.forward.bytes();
  return result;
}

}  // namespace isochor::newton
