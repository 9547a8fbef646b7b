#include "core/dynamics/newton_fast_diagonalization.h"

#include <Eigen/Eigenvalues>
#include <cmath>

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
/// Part of its box below which a body is no box with corners cut: fitted weights take a thin tree twice as
/// long.
constexpr double least_filled = 0.25;

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

/// Of a full box: a node at the end has half of the mass.
std::array<std::vector<double>, 3> uniform_weights(const LatticeLayout& layout) {
  std::array<std::vector<double>, 3> weights;
  for (int axis = 0; axis < 3; ++axis) {
    weights[axis].assign(layout.size[axis] + 1, 1.0);
    weights[axis].front() = weights[axis].back() = 2.0;
  }
  return weights;
}

/// The product of a weight an axis that is nearest to the body's, in the least squares of the logarithms.
std::array<std::vector<double>, 3> separable_weights(const LatticeLayout& layout) {
  const double box = double(layout.size[0]) * layout.size[1] * layout.size[2];
  if (static_cast<double>(layout.cell_slots.size()) < least_filled * box) return uniform_weights(layout);
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
  for (int axis = 0; axis < 3; ++axis) axes_[axis] = make_axis(weights[axis], axis == 0 ? row_ : size_[axis]);
  const std::int64_t count = std::int64_t{row_} * size_[1] * size_[2];
  for (auto* array : {&inverse_eigenvalues_, &values_, &scratch_}) *array = AlignedArray<float>(count);
  set_areas({1.0, 1.0, 1.0});
}

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
