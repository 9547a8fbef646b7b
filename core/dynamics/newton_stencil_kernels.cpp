#include "core/dynamics/newton_kernels.h"
#include "core/dynamics/newton_wide.h"

// Kernels of the conjugate residuals, in float, where products and sums may contract.
namespace isochor::newton::ISOCHOR_WIDE {
namespace {

/// Corner of the neighbour that coincides with a corner of the cell, or −1. Along an axis a step of 1 makes
/// the cell's upper corners the neighbour's lower ones.
constexpr int shared_corner(int corner, Neighbor n) {
  const int steps[3] = {n.x, n.y, n.z};
  int result = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int bit = (corner >> axis & 1) - steps[axis];
    if (bit < 0 || bit > 1) return -1;
    result |= bit << axis;
  }
  return result;
}

template <int k>
inline void assemble_entry(std::int64_t slot, Strides strides, const Gradients& own,
                           const Gradients& neighbors, const Stencil& stencil) {
  constexpr Neighbor n = neighbor(k);
  const std::int64_t other = slot + n.offset(strides);
  Floats result{};
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b) {
    const int c = shared_corner(b, n);
    if (c < 0) continue;
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis)
      result += load(own.value[3 * b + axis] + slot) * load(neighbors.value[3 * c + axis] + other);
  }
  store(stencil.entry[k] + slot, result);
}

template <int... ks>
inline void assemble_entries(std::int64_t slot, Strides strides, const Gradients& own,
                             const Gradients& neighbors, const Stencil& stencil) {
  (assemble_entry<ks>(slot, strides, own, neighbors, stencil), ...);
}

void assemble(Runs runs, Strides strides, Gradients own, Gradients neighbors, Stencil stencil) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes)
      assemble_entries<0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23,
                       24, 25, 26>(s, strides, own, neighbors, stencil);
}

void apply(Runs runs, Strides strides, Stencil stencil, const float* z, float* image,
           const EarlierDirections& earlier, double* products) {
  std::int64_t offsets[stencil_size];
  for (int k = 0; k < stencil_size; ++k) offsets[k] = neighbor(k).offset(strides);
  Floats sums[depth] = {};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      Floats partial[3] = {};
#pragma GCC unroll 27
      for (int k = 0; k < stencil_size; ++k)
        partial[k % 3] += load(stencil.entry[k] + s) * load(z + s + offsets[k]);
      const Floats result = partial[0] + partial[1] + partial[2];
      store(image + s, result);
      for (int i = 0; i < earlier.count; ++i) sums[i] += result * load(earlier.at[i].preconditioned + s);
    }
  for (int i = 0; i < depth; ++i) products[i] = sum(sums[i]);
}

void combine(Runs runs, const EarlierDirections& earlier, const float* factors, const float* z,
             Direction direction, const float* scale, float* scaled) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      Floats search = load(z + s), image = load(direction.image + s);
      for (int i = 0; i < earlier.count; ++i) {
        search -= factors[i] * load(earlier.at[i].search + s);
        image -= factors[i] * load(earlier.at[i].image + s);
      }
      store(direction.search + s, search);
      store(direction.image + s, image);
      store(scaled + s, load(scale + s) * image);
    }
}

Products precondition(Runs runs, Direction direction, const float* scale, const float* z) {
  Floats with_itself{}, with_residual{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats image = load(direction.image + s);
      const Floats scaled = load(scale + s) * load(direction.preconditioned + s);
      store(direction.preconditioned + s, scaled);
      with_itself += image * scaled;
      with_residual += image * load(z + s);
    }
  return {sum(with_itself), sum(with_residual)};
}

float advance(Runs runs, float alpha, Direction direction, const float* weight, float* solution,
              float* residual, float* z) {
  Floats worst{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      store(solution + s, load(solution + s) + alpha * load(direction.search + s));
      store(z + s, load(z + s) - alpha * load(direction.preconditioned + s));
      const Floats rest = load(residual + s) - alpha * load(direction.image + s);
      store(residual + s, rest);
      worst = maximum(worst, absolute(load(weight + s) * rest));
    }
  return largest(worst);
}

/// height rows of width vectors of C = A·B, kept in registers over the inner dimension.
template <int height, int width>
inline void product_tile(const SmallProduct& p, int row, int column) {
  Floats sums[height][width] = {};
  const float* a = p.a + row * p.a_row;
  const float* b = p.b + column;
  for (int k = 0; k < p.inner; ++k, a += p.a_column, b += p.b_row) {
    Floats right[width];
#pragma GCC unroll 4
    for (int j = 0; j < width; ++j) right[j] = load(b + j * lanes);
#pragma GCC unroll 8
    for (int i = 0; i < height; ++i) {
      const Floats left = broadcast(a[i * p.a_row]);
#pragma GCC unroll 4
      for (int j = 0; j < width; ++j) sums[i][j] += left * right[j];
    }
  }
#pragma GCC unroll 8
  for (int i = 0; i < height; ++i)
#pragma GCC unroll 4
    for (int j = 0; j < width; ++j) store(p.c + (row + i) * p.c_row + column + j * lanes, sums[i][j]);
}

template <int width>
inline void product_column(const SmallProduct& p, int column) {
  constexpr int height = lanes == 16 ? 8 : 4;
  int row = 0;
  for (; row + height <= p.rows; row += height) product_tile<height, width>(p, row, column);
  for (; row < p.rows; ++row) product_tile<1, width>(p, row, column);
}

void multiply(const SmallProduct& p) {
  int column = 0;
  for (; column + 2 * lanes <= p.columns; column += 2 * lanes) product_column<2>(p, column);
  for (; column < p.columns; column += lanes) product_column<1>(p, column);
}

void solve_columns(const ColumnSolve& solve) {
  constexpr int block = chunk, longest = 256;
  alignas(64) float modes[longest * block];
  for (int column = 0; column < solve.columns; column += block) {
    float* values = solve.values + column;
    multiply(
        {solve.forward, solve.size, 1, values, solve.stride, modes, block, solve.size, block, solve.size});
    for (int k = 0; k < solve.size; ++k)
      for (int i = 0; i < block; i += lanes)
        store(modes + k * block + i,
              load(modes + k * block + i) * load(solve.inverse_diagonal + column + k * solve.stride + i));
    multiply(
        {solve.backward, solve.size, 1, modes, block, values, solve.stride, solve.size, block, solve.size});
  }
}

}  // namespace

extern const StencilKernels stencil_kernels_table;
const StencilKernels stencil_kernels_table{assemble, apply,    combine,      precondition,
                                           advance,  multiply, solve_columns};

}  // namespace isochor::newton::ISOCHOR_WIDE
