#include "core/dynamics/cell_volume_kernel.h"
#include "core/dynamics/newton_kernels.h"
#include "core/dynamics/newton_wide_cells.h"

namespace isochor::newton::ISOCHOR_WIDE {
namespace {

inline CentralAndApexes<Doubles> load_corners(Points points, std::int64_t slot, Strides strides) {
  CentralAndApexes<Doubles> cells;
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b) {
    const std::int64_t s = slot + corner_offset(b, strides);
    cells[b] = {load(points.x + s), load(points.y + s), load(points.z + s)};
  }
  return cells;
}

void errors(Runs runs, Strides strides, Points points, const double* inverse_volumes, double* result,
            ErrorSums* sums) {
  Doubles squares{}, largest_error{}, excess{}, smallest_tet = broadcast(1.0);
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += double_lanes) {
      const Doubles inverse = load(inverse_volumes + s);
      CentralAndApexes<Doubles> cells = load_corners(points, s, strides);
      exchange(cells, inverse < 0.0);
      const Doubles present = inverse != 0.0 ? broadcast(1.0) : Doubles{};
      const auto sixfold = detail::sixfold_tets(cells.central, cells.apexes);
      const Doubles error = sixfold.sum() * inverse - present;
      store(result + s, error);
      squares += error * error;
      largest_error = maximum(largest_error, absolute(error));
      // V0 = 1/(6·|inverse|); the sum is kept six times too large until its end.
      excess += inverse != 0.0 ? error / absolute(inverse) : Doubles{};
      for (const Doubles& tet : sixfold.tet)
        smallest_tet = inverse != 0.0 ? minimum(tet * inverse, smallest_tet) : smallest_tet;
    }
  *sums = {sum(squares), largest(largest_error), sum(excess) / 6.0, smallest(smallest_tet)};
}

/// (last of before, all but the last of now).
inline Doubles shifted(const Doubles& before, const Doubles& now) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(before, now, 7, 8, 9, 10, 11, 12, 13, 14);
#elif defined(__AVX2__)
  return __builtin_shufflevector(before, now, 3, 4, 5, 6);
#else
  return __builtin_shufflevector(before, now, 1, 2);
#endif
}

/// Sums the forces of corners b and b+1, which lie a slot apart, along a run of slots.
struct Accumulator {
  double* target;
  Doubles pending{};

  void add(std::int64_t slot, const Doubles& first, const Doubles& second) {
    store(target + slot, load(target + slot) + first + shifted(pending, second));
    pending = second;
  }
  void finish(std::int64_t end) { target[end] += pending[double_lanes - 1]; }
};

void forces(Runs runs, Strides strides, Points points, const float* sign, const float* multipliers,
            double factor, Points forces) {
  for (std::int64_t r = 0; r < runs.count; ++r) {
    Accumulator sums[4][3];
    for (int pair = 0; pair < 4; ++pair) {
      const std::int64_t offset = corner_offset(2 * pair, strides);
      sums[pair][0] = {forces.x + offset};
      sums[pair][1] = {forces.y + offset};
      sums[pair][2] = {forces.z + offset};
    }
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += double_lanes) {
      const Doubles signs = __builtin_convertvector(load<HalfFloats>(sign + s), Doubles);
      const Doubles multiplier =
          __builtin_convertvector(load<HalfFloats>(multipliers + s), Doubles) * signs * factor;
      CentralAndApexes<Doubles> cells = load_corners(points, s, strides), sixfold;
      exchange(cells, signs < 0.0);
      detail::sixfold_gradient(cells.central, cells.apexes, sixfold.central, sixfold.apexes);
      exchange(sixfold, signs < 0.0);
#pragma GCC unroll 4
      for (int pair = 0; pair < 4; ++pair) {
        const Point<Doubles>&a = sixfold[2 * pair], &b = sixfold[2 * pair + 1];
        sums[pair][0].add(s, multiplier * a.x, multiplier * b.x);
        sums[pair][1].add(s, multiplier * a.y, multiplier * b.y);
        sums[pair][2].add(s, multiplier * a.z, multiplier * b.z);
      }
    }
    for (auto& pair : sums)
      for (Accumulator& axis : pair) axis.finish(runs.first[r].end);
  }
}

void accelerate(Runs nodes, const double* inverse_masses, Points forces, Points direction, Points points,
                Points result) {
  double* const arrays[3][4] = {{forces.x, direction.x, points.x, result.x},
                                {forces.y, direction.y, points.y, result.y},
                                {forces.z, direction.z, points.z, result.z}};
  for (std::int64_t r = 0; r < nodes.count; ++r)
    for (std::int64_t s = nodes.first[r].begin; s < nodes.first[r].end; s += double_lanes)
#pragma GCC unroll 3
      for (const auto& [force, step, from, to] : arrays) {
        const Doubles change = load(inverse_masses + s) * load(force + s);
        store(force + s, Doubles{});
        store(step + s, change);
        store(to + s, load(from + s) + change);
      }
}

void move(Runs nodes, Points points, double t, Points direction, Points result) {
  double* const arrays[3][3] = {{points.x, direction.x, result.x},
                                {points.y, direction.y, result.y},
                                {points.z, direction.z, result.z}};
  for (std::int64_t r = 0; r < nodes.count; ++r)
    for (std::int64_t s = nodes.first[r].begin; s < nodes.first[r].end; s += double_lanes)
#pragma GCC unroll 3
      for (const auto& [from, step, to] : arrays) store(to + s, load(from + s) + t * load(step + s));
}

}  // namespace

extern const CellKernels cell_kernels_table;
const CellKernels cell_kernels_table{errors, forces, accelerate, move};

}  // namespace isochor::newton::ISOCHOR_WIDE
