#include "core/dynamics/newton_checkerboards.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace isochor::newton {
namespace {

/// Of more, their inverse costs more than the iterations that it saves.
constexpr std::int64_t most_blocks = 192;
/// Of the mean energy: a checkerboard may have none.
constexpr double least_energy = 1e-5;

/// Numbers the blocks of so many cells an edge that hold a cell; returns their count.
std::int64_t number_blocks(const LatticeLayout& layout, int edge, AlignedArray<std::int32_t>& blocks) {
  std::array<int, 3> size;
  for (int axis = 0; axis < 3; ++axis) size[axis] = (layout.size[axis] + edge - 1) / edge;
  std::vector<std::int32_t> numbers(std::size_t{1} * size[0] * size[1] * size[2], -1);
  std::int32_t count = 0;
  for (const std::int32_t slot : layout.cell_slots) {
    const auto [i, j, k] = layout.coord(slot);
    std::int32_t& number = numbers[(std::size_t{1} * (k / edge) * size[1] + j / edge) * size[0] + i / edge];
    if (number < 0) number = count++;
    blocks[slot] = number;
  }
  return count;
}

}  // namespace

Checkerboards::Checkerboards(const LatticeLayout& layout, const Stencil& at_rest)
    : blocks_(layout.slots), signs_(layout.slots) {
  set_blocks(layout);
  throw_if_scope_cancelled();
  set_inverse(layout, at_rest);
}

void Checkerboards::set_blocks(const LatticeLayout& layout) {
  const double cells = static_cast<double>(layout.cell_slots.size());
  int edge = std::max(2, static_cast<int>(std::cbrt(cells / most_blocks)));
  while ((count_ = number_blocks(layout, edge, blocks_)) > most_blocks) ++edge;
  row_ = (count_ + chunk - 1) / chunk * chunk;
  cells_ = layout.cell_slots;
  std::ranges::stable_sort(cells_, {}, [&](std::int32_t slot) { return blocks_[slot]; });
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    signs_[cells_[c]] = layout.parity(cells_[c]) ? -1.0F : 1.0F;
    if (c == 0 || blocks_[cells_[c]] != blocks_[cells_[c - 1]])
      first_.push_back(static_cast<std::int32_t>(c));
  }
  first_.push_back(static_cast<std::int32_t>(cells_.size()));
}

void Checkerboards::set_inverse(const LatticeLayout& layout, const Stencil& at_rest) {
  Eigen::MatrixXd energy = Eigen::MatrixXd::Zero(count_, count_);
  for (const std::int32_t slot : cells_)
    for (int k = 0; k < stencil_size; ++k) {
      const std::int64_t other = slot + neighbor(k).offset(layout.strides);
      energy(blocks_[slot], blocks_[other]) += double{signs_[slot]} * signs_[other] * at_rest.entry[k][slot];
    }
  energy.diagonal().array() += least_energy * energy.trace() / static_cast<double>(count_);
  const Eigen::MatrixXd inverse = energy.llt().solve(Eigen::MatrixXd::Identity(count_, count_));
  inverse_ = AlignedArray<float>(count_ * row_);
  for (std::int64_t i = 0; i < count_; ++i)
    for (std::int64_t j = 0; j < count_; ++j) inverse_[i * row_ + j] = static_cast<float>(inverse(i, j));
  for (auto* array : {&sums_, &heights_}) *array = AlignedArray<float>(row_);
}

void Checkerboards::solve(const float* residual) {
  for (std::int64_t block = 0; block < count_; ++block) {
    float sum = 0.0F;
    for (std::int32_t c = first_[block]; c < first_[block + 1]; ++c)
      sum += signs_[cells_[c]] * residual[cells_[c]];
    sums_[block] = sum;
  }
  stencil_kernels().multiply({sums_.data(), count_, 1, inverse_.data(), row_, heights_.data(), row_, 1,
                              static_cast<int>(row_), static_cast<int>(count_)});
}

std::int64_t Checkerboards::bytes() const {
  return blocks_.bytes() + signs_.bytes() + inverse_.bytes() + sums_.bytes() + heights_.bytes() +
         static_cast<std::int64_t>((cells_.size() + first_.size()) * sizeof(std::int32_t));
}

}  // namespace isochor::newton
