#include "core/dynamics/newton_kernels.h"
#include "core/dynamics/newton_wide.h"

// Kernels of the conjugate gradients, in float, where products and sums may contract.
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

template <int direction>
inline void assemble_entry(std::int64_t slot, Strides strides, const Gradients& gradients,
                           const Stencil& stencil) {
  constexpr Neighbor neighbor = successors[direction];
  const std::int64_t other = slot + neighbor.offset(strides);
  Floats result{};
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b) {
    const int c = shared_corner(b, neighbor);
    if (c < 0) continue;
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis)
      result += load(gradients.value[3 * b + axis] + slot) * load(gradients.value[3 * c + axis] + other);
  }
  store(stencil.entry[direction] + slot, result);
}

template <int... directions>
inline void assemble_entries(std::int64_t slot, Strides strides, const Gradients& gradients,
                             const Stencil& stencil) {
  (assemble_entry<directions>(slot, strides, gradients, stencil), ...);
}

void assemble(Runs runs, Strides strides, Gradients gradients, Stencil stencil) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes)
      assemble_entries<0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13>(s, strides, gradients, stencil);
}

double apply(Runs runs, Strides strides, Stencil stencil, const float* search, float* image) {
  std::int64_t offsets[stencil_size];
  for (int k = 0; k < stencil_size; ++k) offsets[k] = successors[k].offset(strides);
  Floats curvature{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats center = load(search + s);
      Floats ahead = load(stencil.entry[0] + s) * center, behind{};
#pragma GCC unroll 13
      for (int k = 1; k < stencil_size; ++k) {
        ahead += load(stencil.entry[k] + s) * load(search + s + offsets[k]);
        behind += load(stencil.entry[k] + s - offsets[k]) * load(search + s - offsets[k]);
      }
      const Floats result = ahead + behind;
      store(image + s, result);
      curvature += center * result;
    }
  return sum(curvature);
}

float advance(Runs runs, float alpha, const float* search, const float* image, const float* scale,
              const float* weight, float* solution, float* residual, float* scaled) {
  Floats worst{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      store(solution + s, load(solution + s) + alpha * load(search + s));
      const Floats rest = load(residual + s) - alpha * load(image + s);
      store(residual + s, rest);
      store(scaled + s, load(scale + s) * rest);
      worst = maximum(worst, absolute(load(weight + s) * rest));
    }
  return largest(worst);
}

double precondition(Runs runs, const float* scale, const float* residual, float* z) {
  Floats product{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats scaled = load(scale + s) * load(z + s);
      store(z + s, scaled);
      product += scaled * load(residual + s);
    }
  return sum(product);
}

void turn(Runs runs, float beta, const float* z, float* search) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes)
      store(search + s, load(z + s) + beta * load(search + s));
}

DiagonalStep advance_diagonal(Runs runs, float alpha, const float* search, const float* image,
                              const float* inverse_diagonal, const float* weight, float* solution,
                              float* residual) {
  Floats product{}, worst{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      store(solution + s, load(solution + s) + alpha * load(search + s));
      const Floats rest = load(residual + s) - alpha * load(image + s);
      store(residual + s, rest);
      product += load(inverse_diagonal + s) * rest * rest;
      worst = maximum(worst, absolute(load(weight + s) * rest));
    }
  return {sum(product), largest(worst)};
}

void turn_diagonal(Runs runs, float beta, const float* inverse_diagonal, const float* residual,
                   float* search) {
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes)
      store(search + s, load(inverse_diagonal + s) * load(residual + s) + beta * load(search + s));
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
const StencilKernels stencil_kernels_table{assemble,         apply,         advance,  precondition, turn,
                                           advance_diagonal, turn_diagonal, multiply, solve_columns};

}  // namespace isochor::newton::ISOCHOR_WIDE
