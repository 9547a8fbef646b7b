#include "core/dynamics/saddle_preconditioner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/common/wide.h"
#include "core/dynamics/eigenpairs.h"
#include "core/dynamics/lattice_box.h"
#include "core/parallel/cancel_scope.h"
#include "core/parallel/cancellable_sort.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// N v = cos θ·D v, VᵀDV = 1.
Eigen::MatrixXd node_modes(int cells, std::vector<double>& cosines) {
  Eigen::MatrixXd modes(cells + 1, cells + 1);
  for (int mode = 0; mode <= cells; ++mode) {
    const double theta = std::numbers::pi * mode / cells;
    cosines.push_back(std::cos(theta));
    double norm = 0.0;
    for (int i = 0; i <= cells; ++i) {
      modes(i, mode) = std::cos(theta * i);
      norm += (i == 0 || i == cells ? 1.0 : 2.0) * modes(i, mode) * modes(i, mode);
    }
    modes.col(mode) /= std::sqrt(norm);
  }
  return modes;
}

/// K v = λ G v, VᵀGV = 1, K and G of the differences and means of neighbouring nodes with weights 1/D.
Eigen::MatrixXd cell_modes(int cells, std::vector<double>& eigenvalues, std::vector<double>& cosines) {
  Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(cells, cells + 1), mean = difference;
  for (int i = 0; i < cells; ++i) {
    difference(i, i) = -1.0, difference(i, i + 1) = 1.0;
    mean(i, i) = mean(i, i + 1) = 0.5;
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(cells + 1, 0.5);
  weights[0] = weights[cells] = 1.0;
  const auto [vectors, values] =
      generalized_eigenpairs(difference * weights.asDiagonal() * difference.transpose(),
                             mean * weights.asDiagonal() * mean.transpose());
  for (const double lambda : values) {
    eigenvalues.push_back(lambda);
    cosines.push_back((4.0 - lambda) / (4.0 + lambda));
  }
  return vectors;
}

/// A's eigenvalue for displacements along each axis.
Vec3 stiffness_of_mode(const MeanStiffness& m, const Vec3& cosines) {
  const Vec3 edges = Vec3::Ones() - cosines;
  const double diagonals = 1.0 - cosines.prod();
  const double isotropic = m.edge_isotropic * edges.sum() + m.diagonal_isotropic * diagonals;
  return (m.edge_axial * edges).array() + (m.mass + m.diagonal_axial / 3.0 * diagonals + isotropic);
}

/// In lanes, so that the loop is wide.
ISOCHOR_MULTIVERSION double largest_of(const double* from, std::size_t size) {
  constexpr std::size_t lanes = 8;
  double largest[lanes] = {};
  for (std::size_t i = 0; i + lanes <= size; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double value = std::abs(from[i + lane]);
      largest[lane] = value > largest[lane] ? value : largest[lane];
    }
  for (std::size_t i = size / lanes * lanes; i < size; ++i)
    largest[0] = std::max(largest[0], std::abs(from[i]));
  return *std::max_element(largest, largest + lanes);
}

ISOCHOR_MULTIVERSION void narrow(const double* from, double factor, float* __restrict to, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) to[i] = static_cast<float>(factor * from[i]);
}

ISOCHOR_MULTIVERSION void widen(const float* from, double factor, double* __restrict to, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) to[i] = factor * double{from[i]};
}

}  // namespace

std::optional<BoxPreconditioner> BoxPreconditioner::make(const TetMesh& mesh) {
  if (mesh.grid.size.maxCoeff() > longest) return std::nullopt;
  BoxPreconditioner result(mesh);
  throw_if_scope_cancelled();
  std::vector<std::int32_t> taken = result.node_slots_;
  cancellable_sort(taken);
  throw_if_scope_cancelled();
  if (std::ranges::adjacent_find(taken) != taken.end()) return std::nullopt;
  return result;
}

BoxPreconditioner::BoxPreconditioner(const TetMesh& mesh) {
  const LatticeBox box(mesh);
  const auto &low = box.low, &size = box.size;
  const auto slot = [&](const std::array<std::int32_t, 3>& at, int more) {
    return (at[0] - low[0]) + (size[0] + more) * ((at[1] - low[1]) + (size[1] + more) * (at[2] - low[2]));
  };
  for (const auto& node : mesh.nodes) node_slots_.push_back(slot(node, 1));
  for (const Cell& cell : mesh.cells) cell_slots_.push_back(slot(cell.coord, 0));
  fits_ = fills_its_box(mesh);
  std::array<Eigen::MatrixXd, 3> of_nodes, of_cells;
  for (int axis = 0; axis < 3; ++axis) {
    of_nodes[axis] = node_modes(size[axis], node_cosines_[axis]);
    of_cells[axis] = cell_modes(size[axis], eigenvalues_[axis], cell_cosines_[axis]);
  }
  for (int axis = 0; axis < 3; ++axis) node_transforms_.emplace_back(of_nodes);
  cell_transform_.emplace_back(of_cells);
  for (auto& values : values_) values = newton::AlignedArray<float>(node_transforms_[0].size());
}

void BoxPreconditioner::prepare(const MeanStiffness& mean, double area) {
  const auto visit = [](const std::array<std::vector<double>, 3>& cosines, const auto& body) {
    for (std::size_t k = 0; k < cosines[2].size(); ++k)
      for (std::size_t j = 0; j < cosines[1].size(); ++j)
        for (std::size_t i = 0; i < cosines[0].size(); ++i)
          body(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k),
               Vec3(cosines[0][i], cosines[1][j], cosines[2][k]));
  };
  visit(node_cosines_, [&](int i, int j, int k, const Vec3& cosines) {
    const Vec3 stiffness = stiffness_of_mode(mean, cosines);
    for (int axis = 0; axis < 3; ++axis)
      node_transforms_[axis].weight(i, j, k) = static_cast<float>(mean.mass / stiffness[axis]);
  });
  visit(cell_cosines_, [&](int i, int j, int k, const Vec3& cosines) {
    const Vec3 lambda(eigenvalues_[0][i], eigenvalues_[1][j], eigenvalues_[2][k]);
    const double s = mean.mass * lambda.cwiseQuotient(stiffness_of_mode(mean, cosines)).sum();
    cell_transform_[0].weight(i, j, k) = static_cast<float>(1.0 / s);
  });
  node_scale_ = 1.0 / mean.mass;
  cell_scale_ = mean.mass / (area * area);
}

void BoxPreconditioner::apply(const BoxTransform& transform, const std::vector<std::int32_t>& slots,
                              double scale, const double* from, double* to, float* values) const {
  const double largest = largest_of(from, slots.size());
  if (!(largest > 0.0) || !std::isfinite(largest)) {
    std::fill_n(to, slots.size(), 0.0);
    return;
  }
  if (fits_) {  // slots are 0, 1, 2, …
    narrow(from, 1.0 / largest, values, slots.size());
    transform.apply(values);
    widen(values, scale * largest, to, slots.size());
    return;
  }
  std::fill_n(values, transform.size(), 0.0F);
  for (std::size_t i = 0; i < slots.size(); ++i) values[slots[i]] = static_cast<float>(from[i] / largest);
  transform.apply(values);
  for (std::size_t i = 0; i < slots.size(); ++i) to[i] = scale * largest * double{values[slots[i]]};
}

void BoxPreconditioner::nodes(const Coordinates& from, Coordinates& to) {
  const std::array<const double*, 3> sources{from.x.data(), from.y.data(), from.z.data()};
  const std::array<double*, 3> targets{to.x.data(), to.y.data(), to.z.data()};
  parallel_for(3, 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto axis = static_cast<std::size_t>(begin); axis < static_cast<std::size_t>(end); ++axis)
      apply(node_transforms_[axis], node_slots_, node_scale_, sources[axis], targets[axis],
            values_[axis].data());
  });
}

void BoxPreconditioner::cells(const std::vector<double>& from, std::vector<double>& to) {
  apply(cell_transform_[0], cell_slots_, cell_scale_, from.data(), to.data(), values_[0].data());
}

std::int64_t BoxPreconditioner::bytes() const {
  std::int64_t result = 3 * values_[0].bytes() + cell_transform_[0].bytes();
  for (const BoxTransform& transform : node_transforms_) result += transform.bytes();
  return result + static_cast<std::int64_t>((node_slots_.size() + cell_slots_.size()) * sizeof(std::int32_t));
}

}  // namespace isochor
