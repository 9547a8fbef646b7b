#include "core/dynamics/newton_stencil_solver.h"

#include <cmath>

namespace isochor::newton {
namespace {

/// A row with less than this part of the box's diagonal belongs to a collapsed cell.
constexpr float collapsed = 1e-10F;

}  // namespace

StencilSolver::StencilSolver(const LatticeLayout& layout, const AlignedArray<float>& weights)
    : layout_(layout), weights_(weights), entries_(stencil_size * layout.slots) {
  for (int k = 0; k < stencil_size; ++k) stencil_.entry[k] = entries_.data() + k * layout.slots;
  for (auto* array : {&solution_, &residual_, &scaled_, &z_, &search_, &image_, &box_diagonal_, &scale_})
    *array = AlignedArray<float>(layout.slots);
  const auto [nx, ny, nz] = layout.size;
  if (std::max({nx, ny, nz}) <= FastDiagonalization::longest) box_.emplace(layout);
  for (const std::int32_t slot : layout.cell_slots) {
    const std::int64_t offset = slot - layout.origin, in_plane = offset % layout.strides.plane;
    box_diagonal_[slot] = 1.0F;
    if (box_)
      box_diagonal_[slot] = static_cast<float>(box_->diagonal(
          static_cast<int>(in_plane % layout.strides.row), static_cast<int>(in_plane / layout.strides.row),
          static_cast<int>(offset / layout.strides.plane)));
  }
}

void StencilSolver::add(std::int32_t a, std::int32_t b, float value) {
  const std::int64_t first = std::min(a, b), distance = std::max(a, b) - first;
  for (int k = 0; k < stencil_size; ++k)
    if (distance == successors[k].offset(layout_.strides)) stencil_.entry[k][first] += value;
}

void StencilSolver::prepare(const std::array<double, 3>& areas) {
  if (box_) box_->set_areas(areas);
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    for (const Run& run : slab.cells)
      for (std::int32_t s = run.begin; s < run.end; ++s) {
        const float diagonal = stencil_.entry[0][s], reference = box_diagonal_[s];
        const bool present = diagonal > collapsed * reference && std::isfinite(diagonal);
        scale_[s] = present ? (box_ ? std::sqrt(reference / diagonal) : 1.0F / diagonal) : 0.0F;
      }
}

double StencilSolver::apply() {
  double product = 0.0;
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    product += stencil_kernels().apply(as_runs(slab.cells), layout_.strides, stencil_, search_.data(),
                                       image_.data());
  return product + apply_carriers();
}

double StencilSolver::apply_carriers() {
  double product = 0.0;
  for (const CarrierRows& carrier : carriers_) {
    Eigen::Matrix<float, 6, 1> pull = Eigen::Matrix<float, 6, 1>::Zero();
    for (const CarrierRows::Row& row : carrier.rows) pull += search_[row.slot] * row.pull;
    const Eigen::Matrix<float, 6, 1> motion = carrier.inverse_mass * pull;
    for (const CarrierRows::Row& row : carrier.rows) image_[row.slot] += row.pull.dot(motion);
    product += pull.dot(motion);
  }
  return product;
}

/// Moves along the search direction and preconditions the new residual.
StencilSolver::Progress StencilSolver::advance(float alpha) {
  Progress progress;
  const auto& kernels = stencil_kernels();
  for (const LatticeLayout::Slab& slab : layout_.slabs) {
    if (box_) {
      progress.worst =
          std::max(progress.worst,
                   kernels.advance(as_runs(slab.cells), alpha, search_.data(), image_.data(), scale_.data(),
                                   weights_.data(), solution_.data(), residual_.data(), scaled_.data()));
    } else {
      const DiagonalStep step =
          kernels.advance_diagonal(as_runs(slab.cells), alpha, search_.data(), image_.data(), scale_.data(),
                                   weights_.data(), solution_.data(), residual_.data());
      progress.product += step.product;
      progress.worst = std::max(progress.worst, step.worst);
    }
  }
  if (!box_) return progress;
  box_->apply(scaled_.data(), z_.data());
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    progress.product += kernels.precondition(as_runs(slab.cells), scale_.data(), residual_.data(), z_.data());
  return progress;
}

/// The next search direction.
void StencilSolver::turn(float beta) {
  for (const LatticeLayout::Slab& slab : layout_.slabs) {
    if (box_)
      stencil_kernels().turn(as_runs(slab.cells), beta, z_.data(), search_.data());
    else
      stencil_kernels().turn_diagonal(as_runs(slab.cells), beta, scale_.data(), residual_.data(),
                                      search_.data());
  }
}

int StencilSolver::solve(double tolerance) {
  // Slow progress is no reason to stop, but none at all is: then the rows contradict each other.
  constexpr int patience = 100, most_iterations = 3000;
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    for (const Run& run : slab.cells)
      for (std::int32_t s = run.begin; s < run.end; ++s) {
        solution_[s] = search_[s] = image_[s] = 0.0F;
        if (scale_[s] == 0.0F) residual_[s] = 0.0F;
      }
  Progress progress = advance(0.0F);
  turn(0.0F);
  const auto goal = static_cast<float>(tolerance) * progress.worst;
  float best = progress.worst;
  int iteration = 0, since_best = 0;
  while (progress.worst > goal && iteration < most_iterations && since_best < patience) {
    ++iteration;
    const double curvature = apply(), before = progress.product;
    if (!(curvature > 0.0) || !std::isfinite(curvature)) break;
    progress = advance(static_cast<float>(before / curvature));
    if (!(progress.product > 0.0)) break;
    turn(static_cast<float>(progress.product / before));
    since_best = progress.worst < 0.9F * best ? 0 : since_best + 1;
    best = std::min(best, progress.worst);
  }
  return iteration;
}

std::int64_t StencilSolver::bytes() const {
  return entries_.bytes() + 8 * solution_.bytes() + (box_ ? box_->bytes() : 0);
}

}  // namespace isochor::newton
