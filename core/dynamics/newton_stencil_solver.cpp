#include "core/dynamics/newton_stencil_solver.h"

#include <array>
#include <cmath>
#include <utility>

namespace isochor::newton {
namespace {

/// A row with less than this part of the box's diagonal belongs to a collapsed cell.
constexpr float collapsed = 1e-10F;
/// The box gives way too easily beneath faces that it does not have. What its diagonal counts there in the
/// first and the second cell: from 0.4 and 0.64 up, the least iterations over balls and tori of 8 to 32
/// cells.
constexpr float first_beneath_face = 0.56F, second_beneath_face = 0.81F;

/// A slot's number from the nearest face of the body within the box, up to 2; 0 for those deeper.
std::vector<std::uint8_t> number_from_faces(const LatticeLayout& layout) {
  std::vector<std::uint8_t> numbers(layout.slots, 0);
  const std::array<std::int64_t, 3> strides{1, layout.strides.row, layout.strides.plane};
  const auto is_beside = [&](std::int32_t cell, const auto& wanted) {
    const std::array<int, 3> coord = layout.coord(cell);
    for (int axis = 0; axis < 3; ++axis)
      if ((coord[axis] > 0 && wanted(cell - strides[axis])) ||
          (coord[axis] + 1 < layout.size[axis] && wanted(cell + strides[axis])))
        return true;
    return false;
  };
  for (const std::int32_t cell : layout.cell_slots)
    if (is_beside(cell, [&](std::int64_t other) { return layout.kinds[other] == LatticeLayout::none; }))
      numbers[cell] = 1;
  for (const std::int32_t cell : layout.cell_slots)
    if (numbers[cell] == 0 && is_beside(cell, [&](std::int64_t other) { return numbers[other] == 1; }))
      numbers[cell] = 2;
  return numbers;
}

/// Directions that are orthogonal to the last few only lead nowhere where gradients have turned far since the
/// start of the step, as those of lifted tets have: the residual's square, which falls by a fifth in every
/// ten iterations of the slowest bodies, then stands within as many. Not so near round-off.
class Stall {
 public:
  bool is_seen(double square) {
    first_ = std::max(first_, square);
    double& before = last_[count_++ % last_.size()];
    const double earlier = std::exchange(before, square);
    return count_ > std::ssize(last_) && square > round_off * first_ && square > standing * earlier;
  }

 private:
  static constexpr double standing = 0.95, round_off = 1e-6;
  std::array<double, 10> last_{};
  std::int64_t count_ = 0;
  double first_ = 0.0;
};

}  // namespace

StencilSolver::StencilSolver(const LatticeLayout& layout)
    : layout_(layout), entries_(stencil_size * layout.slots), partial_(layout.slabs.size()) {
  for (int k = 0; k < stencil_size; ++k) stencil_.entry[k] = entries_.data() + k * layout.slots;
  for (auto* array : {&solution_, &residual_, &scaled_, &z_, &box_diagonal_, &scale_})
    *array = AlignedArray<float>(layout.slots);
  for (auto& direction : directions_)
    for (auto& array : direction) array = AlignedArray<float>(layout.slots);
  const auto [nx, ny, nz] = layout.size;
  if (std::max({nx, ny, nz}) <= FastDiagonalization::longest) box_.emplace(layout);
  set_box_diagonal();
}

void StencilSolver::set_box_diagonal() {
  if (!box_) {
    for (const std::int32_t slot : layout_.cell_slots) box_diagonal_[slot] = 1.0F;
    return;
  }
  const std::vector<std::uint8_t> numbers = number_from_faces(layout_);
  constexpr std::array<float, 3> counts{1.0F, first_beneath_face, second_beneath_face};
  for (const std::int32_t slot : layout_.cell_slots) {
    const auto [i, j, k] = layout_.coord(slot);
    box_diagonal_[slot] = counts[numbers[slot]] * static_cast<float>(box_->diagonal(i, j, k));
  }
}

void StencilSolver::add(std::int32_t cell, std::int32_t other, float value) {
  for (int k = 0; k < stencil_size; ++k)
    if (other - cell == neighbor(k).offset(layout_.strides)) stencil_.entry[k][cell] += value;
}

void StencilSolver::prepare(const std::array<double, 3>& areas) {
  if (box_) box_->set_areas(areas);
  set_scale();
}

void StencilSolver::set_scale() {
  layout_.for_slabs([&](std::int64_t, const LatticeLayout::Slab& slab) {
    stencil_kernels().set_scale(as_runs(slab.cells), stencil_.entry[stencil_center], box_diagonal_.data(),
                                collapsed, scale_.data());
  });
}

/// In units of one product of the fast diagonalisation.
double StencilSolver::cost_of_iteration() const {
  constexpr double of_a_slot = 200.0, of_a_block_pair = 3.0;  // bound by memory, as measured
  std::int64_t slots = 0;
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    for (const Run& run : slab.cells) slots += run.end - run.begin;
  return of_a_slot * static_cast<double>(slots) + (box_ ? box_->products() : 0.0) +
         (checkerboards_ ? of_a_block_pair * checkerboards_->products() : 0.0);
}

void StencilSolver::choose_preconditioner(const double* errors) {
  if (!box_) return;
  constexpr double tolerance = 1e-4;  // as Newton steps ask for; in float neither goes much further
  const double with_box = solve(errors, tolerance) * cost_of_iteration();
  std::optional<FastDiagonalization> box = std::move(box_);
  box_.reset();
  set_box_diagonal();
  set_scale();
  checkerboards_.emplace(layout_, stencil_);
  // Random errors ask more of it, beside the box, than those of a step do.
  const auto affordable = static_cast<int>(1.3 * with_box / cost_of_iteration());
  solve(errors, tolerance, affordable);
  if (reached_) return;
  checkerboards_.reset();
  box_ = std::move(box);
  set_box_diagonal();
  set_scale();
}

Direction StencilSolver::direction(int i) const {
  const auto& [search, image, preconditioned] = directions_[i % (depth + 1)];
  return {search.data(), image.data(), preconditioned.data()};
}

void StencilSolver::apply(const EarlierDirections& earlier, float* image, double* products) {
  layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
    stencil_kernels().apply(as_runs(slab.cells), layout_.strides, stencil_, z_.data(), image, earlier,
                            partial_[i].with_earlier);
  });
  std::fill_n(products, depth, 0.0);
  for (const Partial& partial : partial_)
    for (int i = 0; i < depth; ++i) products[i] += partial.with_earlier[i];
  apply_carriers(earlier, image, products);
}

void StencilSolver::apply_carriers(const EarlierDirections& earlier, float* image, double* products) {
  for (const CarrierRows& carrier : carriers_) {
    CarrierRows::Vector pull = CarrierRows::Vector::Zero();
    for (const CarrierRows::Row& row : carrier.start) pull += z_[row.slot] * row.pull;
    const CarrierRows::Vector motion = carrier.inverse_mass * pull;
    for (const CarrierRows::Row& row : carrier.own) {
      const float change = row.pull.dot(motion);
      image[row.slot] += change;
      for (int i = 0; i < earlier.count; ++i)
        products[i] += double{change} * earlier.at[i].preconditioned[row.slot];
    }
  }
}

CheckerboardHeights StencilSolver::heights() const {
  return checkerboards_ ? checkerboards_->heights() : CheckerboardHeights{};
}

/// to = box⁻¹·scaled, or scaled itself and the checkerboards' heights for the residual that before leaves.
/// Each slab's part of scaled is made by before(i, slab, scaled) and that of to used by after(i, slab), while
/// they are in the cache.
template <class Before, class After>
void StencilSolver::invert_box(const Before& before, const float* residual, float* to, const After& after) {
  if (checkerboards_) {
    layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) { before(i, slab, to); });
    checkerboards_->solve(residual);
    layout_.for_slabs(after);
    return;
  }
  if (!box_) {
    layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
      before(i, slab, to);
      after(i, slab);
    });
    return;
  }
  layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
    before(i, slab, scaled_.data());
    box_->forward(slab, scaled_.data());
  });
  box_->solve_columns();
  layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
    box_->backward(slab, to);
    after(i, slab);
  });
}

/// Makes the direction orthogonal to the earlier ones, and direction.preconditioned = P·direction.image.
Products StencilSolver::precondition(const EarlierDirections& earlier, const float* factors,
                                     const Direction& direction) {
  invert_box(
      [&](std::int64_t, const LatticeLayout::Slab& slab, float* scaled) {
        stencil_kernels().combine(as_runs(slab.cells), earlier, factors, z_.data(), direction, scale_.data(),
                                  scaled);
      },
      direction.image, direction.preconditioned,
      [&](std::int64_t i, const LatticeLayout::Slab& slab) {
        partial_[i].products = stencil_kernels().precondition(as_runs(slab.cells), direction, scale_.data(),
                                                              z_.data(), heights());
      });
  return sum_products();
}

Products StencilSolver::sum_products() const {
  Products sum{};
  for (const Partial& partial : partial_) {
    sum.with_itself += partial.products.with_itself;
    sum.with_residual += partial.products.with_residual;
  }
  return sum;
}

float StencilSolver::advance(float alpha, const Direction& direction) {
  layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
    partial_[i].worst = stencil_kernels().advance(as_runs(slab.cells), alpha, direction, solution_.data(),
                                                  residual_.data(), z_.data());
  });
  return worst_partial();
}

float StencilSolver::worst_partial() const {
  float worst = 0.0F;
  for (const Partial& partial : partial_) worst = std::max(worst, partial.worst);
  return worst;
}

/// residual = −errors, z = P·residual, solution = 0. Returns the largest residual, and its square in P.
StencilSolver::Start StencilSolver::start(const double* errors) {
  const Direction first{nullptr, residual_.data(), z_.data()};
  invert_box(
      [&](std::int64_t i, const LatticeLayout::Slab& slab, float* scaled) {
        partial_[i].worst = stencil_kernels().start(as_runs(slab.cells), errors, scale_.data(),
                                                    solution_.data(), residual_.data(), scaled);
      },
      residual_.data(), z_.data(),
      [&](std::int64_t i, const LatticeLayout::Slab& slab) {
        partial_[i].products =
            stencil_kernels().precondition(as_runs(slab.cells), first, scale_.data(), z_.data(), heights());
      });
  return {worst_partial(), sum_products().with_itself};
}

int StencilSolver::solve(const double* errors, double tolerance, int most_iterations) {
  // Near round-off slow progress is no stall, but none at all is: then the rows contradict each other.
  constexpr int patience = 100;
  Stall stall;
  auto [worst, square] = start(errors);
  const auto goal = static_cast<float>(tolerance) * worst;
  float best = worst;
  EarlierDirections earlier{};
  double norms[depth] = {};  // of the earlier directions
  int iteration = 0, since_best = 0;
  while (worst > goal && iteration < most_iterations && since_best < patience) {
    const Direction next = direction(iteration);
    double products[depth];
    apply(earlier, next.image, products);
    float factors[depth];
    for (int i = 0; i < earlier.count; ++i) factors[i] = static_cast<float>(products[i] / norms[i]);
    const Products product = precondition(earlier, factors, next);
    if (!(product.with_itself > 0.0) || !std::isfinite(product.with_itself)) break;
    worst = advance(static_cast<float>(product.with_residual / product.with_itself), next);
    square -= product.with_residual * product.with_residual / product.with_itself;
    earlier.at[iteration % depth] = next;
    norms[iteration % depth] = product.with_itself;
    earlier.count = std::min(earlier.count + 1, depth);
    ++iteration;
    if (stall.is_seen(square)) break;
    since_best = worst < 0.9F * best ? 0 : since_best + 1;
    best = std::min(best, worst);
  }
  reached_ = worst <= goal;
  return iteration;
}

std::int64_t StencilSolver::bytes() const {
  return entries_.bytes() + (6 + 3 * (depth + 1)) * solution_.bytes() + (box_ ? box_->bytes() : 0) +
         (checkerboards_ ? checkerboards_->bytes() : 0);
}

}  // namespace isochor::newton
