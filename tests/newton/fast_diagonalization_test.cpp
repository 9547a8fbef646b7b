#include "core/dynamics/newton_fast_diagonalization.h"

#include <gtest/gtest.h>

#include "tests/newton/body.h"

namespace isochor::newton {
namespace {

using testing::Body;

/// K = D W Dᵀ and G = S W Sᵀ of an axis whose end nodes have one cell beside them and so twice the weight.
struct Axis {
  Eigen::MatrixXd stiffness, mean;
  explicit Axis(int cells) {
    Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(cells, cells + 1), sum = difference;
    for (int i = 0; i < cells; ++i) {
      difference(i, i) = -1.0;
      difference(i, i + 1) = 1.0;
      sum(i, i) = sum(i, i + 1) = 0.5;
    }
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(cells + 1);
    weights[0] = weights[cells] = 2.0;
    stiffness = difference * weights.asDiagonal() * difference.transpose();
    mean = sum * weights.asDiagonal() * sum.transpose();
  }
};

std::vector<double> random_values(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<double> values(count);
  for (double& value : values) value = any(random);
  return values;
}

class FastDiagonalizationOf : public ::testing::TestWithParam<std::array<int, 3>> {};

// Axes of odd and even length, of one cell, of a whole chunk of lanes and of more.
INSTANTIATE_TEST_SUITE_P(Boxes, FastDiagonalizationOf,
                         ::testing::Values(std::array{5, 4, 3}, std::array{4, 7, 2}, std::array{16, 3, 5},
                                           std::array{1, 1, 6}, std::array{17, 6, 1}, std::array{3, 16, 9}));

TEST_P(FastDiagonalizationOf, InvertsTheOperatorOfAFullBox) {
  const auto [nx, ny, nz] = GetParam();
  const Body body = testing::make_box({nx, ny, nz});
  const auto layout = make_lattice_layout(body.mesh);
  ASSERT_TRUE(layout);
  FastDiagonalization box(*layout);
  const std::array<double, 3> areas{1.0, 0.7, 0.4};
  box.set_areas(areas);

  const std::vector<double> values = random_values(layout->cell_slots.size());
  AlignedArray<float> from(layout->slots), to(layout->slots);
  for (std::size_t c = 0; c < values.size(); ++c) from[layout->cell_slots[c]] = static_cast<float>(values[c]);
  for (const auto& slab : layout->slabs) box.forward(slab, from.data());
  box.solve_columns();
  for (const auto& slab : layout->slabs) box.backward(slab, to.data());

  const Axis x(nx), y(ny), z(nz);
  for (std::size_t row = 0; row < values.size(); ++row) {
    const auto& at = body.mesh.cells[row].coord;
    double sum = 0.0;
    for (std::size_t column = 0; column < values.size(); ++column) {
      const auto& other = body.mesh.cells[column].coord;
      const double entry =
          areas[0] * x.stiffness(at[0], other[0]) * y.mean(at[1], other[1]) * z.mean(at[2], other[2]) +
          areas[1] * x.mean(at[0], other[0]) * y.stiffness(at[1], other[1]) * z.mean(at[2], other[2]) +
          areas[2] * x.mean(at[0], other[0]) * y.mean(at[1], other[1]) * z.stiffness(at[2], other[2]);
      sum += entry * double{to[layout->cell_slots[column]]};
    }
    EXPECT_NEAR(sum, values[row], 2e-4) << row;
  }
}

}  // namespace
}  // namespace isochor::newton
