#include "core/dynamics/cell_volume_kernel.h"
#include "core/dynamics/newton_kernels.h"
#include "core/dynamics/newton_wide.h"

// Kernels over cells, in double. Neighbouring cells alternate in parity: an odd cell is an even one with
// corners b and b^1 exchanged, so a lane takes either of two loads.
namespace isochor::newton::ISOCHOR_WIDE {
namespace {

using detail::Point;

std::int64_t corner_offset(int corner, Strides strides) {
  return (corner & 1) + (corner >> 1 & 1) * strides.row + (corner >> 2 & 1) * strides.plane;
}

/// Corners as an even cell names them.
template <class V>
struct CentralAndApexes {
  Point<V> central[4], apexes[4];

  Point<V>& operator[](int corner) {
    for (int i = 0; i < 4; ++i) {
      if (corner == detail::central_corners[i]) return central[i];
      if (corner == (detail::central_corners[i] ^ 7)) return apexes[i];
    }
    __builtin_unreachable();
  }
};

/// Exchanges the corners b and b^1 of odd cells.
template <class V, class Mask>
inline void exchange(CentralAndApexes<V>& cells, const Mask& odd) {
#pragma GCC unroll 4
  for (int b = 0; b < 8; b += 2) {
    const Point<V> p = cells[b], q = cells[b + 1];
    cells[b] = {odd ? q.x : p.x, odd ? q.y : p.y, odd ? q.z : p.z};
    cells[b + 1] = {odd ? p.x : q.x, odd ? p.y : q.y, odd ? p.z : q.z};
  }
}

inline CentralAndApexes<Doubles> load_corners(Points points, std::int64_t slot, Strides strides) {
  CentralAndApexes<Doubles> cells;
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b) {
    const std::int64_t s = slot + corner_offset(b, strides);
    cells[b] = {load(points.x + s), load(points.y + s), load(points.z + s)};
  }
  return cells;
}

void errors(Runs runs, Strides strides, Points points, const double* inverse_sixfold, double* result,
            ErrorSums* sums) {
  Doubles squares{}, largest_error{}, excess{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += double_lanes) {
      const Doubles inverse = load(inverse_sixfold + s);
      CentralAndApexes<Doubles> cells = load_corners(points, s, strides);
      exchange(cells, inverse < 0.0);
      const Doubles present = inverse != 0.0 ? broadcast(1.0) : Doubles{};
      const Doubles error = detail::sixfold_volume(cells.central, cells.apexes) * inverse - present;
      store(result + s, error);
      squares += error * error;
      largest_error = maximum(largest_error, absolute(error));
      // V0 = 1/(6·|inverse|); the sum is kept six times too large until its end.
      excess += inverse != 0.0 ? error / absolute(inverse) : Doubles{};
    }
  *sums = {sum(squares), largest(largest_error), sum(excess) / 6.0};
}

inline Floats to_floats(const Doubles& low, const Doubles& high) {
  const HalfFloats a = __builtin_convertvector(low, HalfFloats),
                   b = __builtin_convertvector(high, HalfFloats);
  Floats result;
  __builtin_memcpy(&result, &a, sizeof a);
  __builtin_memcpy(reinterpret_cast<char*>(&result) + sizeof a, &b, sizeof b);
  return result;
}

/// Differences to the cell's corner 0 are taken in double, so that a body far away loses nothing.
inline Floats load_difference(const double* values, std::int64_t slot, std::int64_t offset,
                              double inverse_length) {
  const double* low = values + slot;
  const double* high = low + double_lanes;
  return to_floats((load(low + offset) - load(low)) * inverse_length,
                   (load(high + offset) - load(high)) * inverse_length);
}

void gradients(Runs runs, Strides strides, Points points, const float* sign, const float* root_weights,
               double inverse_length, Gradients result) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats signs = load(sign + s);
      const FloatMask odd = signs < 0.0F;
      CentralAndApexes<Floats> cells, sixfold;
#pragma GCC unroll 8
      for (int b = 0; b < 8; ++b) {
        const std::int64_t offset = corner_offset(b, strides);
        cells[b] = {load_difference(points.x, s, offset, inverse_length),
                    load_difference(points.y, s, offset, inverse_length),
                    load_difference(points.z, s, offset, inverse_length)};
      }
      exchange(cells, odd);
      detail::sixfold_gradient(cells.central, cells.apexes, sixfold.central, sixfold.apexes);
      exchange(sixfold, odd);
#pragma GCC unroll 8
      for (int b = 0; b < 8; ++b) {
        const Floats factor = signs * load(root_weights + s + corner_offset(b, strides));
        store(result.value[3 * b] + s, factor * sixfold[b].x);
        store(result.value[3 * b + 1] + s, factor * sixfold[b].y);
        store(result.value[3 * b + 2] + s, factor * sixfold[b].z);
      }
    }
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
            double factor, Points lower, Points upper) {
  for (std::int64_t r = 0; r < runs.count; ++r) {
    Accumulator sums[4][3];
    for (int pair = 0; pair < 4; ++pair) {
      const Points& target = pair < 2 ? lower : upper;
      const std::int64_t offset = corner_offset(2 * pair, strides);
      sums[pair][0] = {target.x + offset};
      sums[pair][1] = {target.y + offset};
      sums[pair][2] = {target.z + offset};
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

void accelerate(Runs nodes, const double* inverse_masses, Points lower, Points upper, Points direction) {
  double* const from[3][2] = {{lower.x, upper.x}, {lower.y, upper.y}, {lower.z, upper.z}};
  double* const to[3] = {direction.x, direction.y, direction.z};
  for (std::int64_t r = 0; r < nodes.count; ++r)
    for (std::int64_t s = nodes.first[r].begin; s < nodes.first[r].end; s += double_lanes)
      for (int axis = 0; axis < 3; ++axis) {
        store(to[axis] + s, load(inverse_masses + s) * (load(from[axis][0] + s) + load(from[axis][1] + s)));
        store(from[axis][0] + s, Doubles{});
        store(from[axis][1] + s, Doubles{});
      }
}

void move(Runs nodes, Points points, double t, Points direction, Points result) {
  double* const from[3][2] = {{points.x, direction.x}, {points.y, direction.y}, {points.z, direction.z}};
  double* const to[3] = {result.x, result.y, result.z};
  for (std::int64_t r = 0; r < nodes.count; ++r)
    for (std::int64_t s = nodes.first[r].begin; s < nodes.first[r].end; s += double_lanes)
      for (int axis = 0; axis < 3; ++axis)
        store(to[axis] + s, load(from[axis][0] + s) + t * load(from[axis][1] + s));
}

void middle(Runs nodes, Points a, Points b, Points result) {
  double* const from[3][2] = {{a.x, b.x}, {a.y, b.y}, {a.z, b.z}};
  double* const to[3] = {result.x, result.y, result.z};
  for (std::int64_t r = 0; r < nodes.count; ++r)
    for (std::int64_t s = nodes.first[r].begin; s < nodes.first[r].end; s += double_lanes)
      for (int axis = 0; axis < 3; ++axis)
        store(to[axis] + s, 0.5 * (load(from[axis][0] + s) + load(from[axis][1] + s)));
}

}  // namespace

extern const CellKernels cell_kernels_table;
const CellKernels cell_kernels_table{errors, gradients, forces, accelerate, move, middle};

}  // namespace isochor::newton::ISOCHOR_WIDE
