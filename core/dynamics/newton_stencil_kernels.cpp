#include "core/dynamics/newton_wide_cells.h"

// Kernels of the conjugate residuals, in float, where products and sums may contract.
namespace isochor::newton::ISOCHOR_WIDE {
namespace {

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

inline CentralAndApexes<Floats> cell_gradients(const Cells& cells, std::int64_t slot) {
  const Floats signs = load(cells.sign + slot);
  const FloatMask odd = signs < 0.0F;
  CentralAndApexes<Floats> corners, gradients;
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b) {
    const std::int64_t offset = corner_offset(b, cells.strides);
    corners[b] = {load_difference(cells.points.x, slot, offset, cells.inverse_length),
                  load_difference(cells.points.y, slot, offset, cells.inverse_length),
                  load_difference(cells.points.z, slot, offset, cells.inverse_length)};
  }
  exchange(corners, odd);
  detail::sixfold_gradient(corners.central, corners.apexes, gradients.central, gradients.apexes);
  exchange(gradients, odd);
#pragma GCC unroll 8
  for (int b = 0; b < 8; ++b)
    gradients[b] = {signs * gradients[b].x, signs * gradients[b].y, signs * gradients[b].z};
  return gradients;
}

void gradients(const Cells& cells, const float* weights, Gradients result) {
  for (std::int64_t r = 0; r < cells.runs.count; ++r)
    for (std::int64_t s = cells.runs.first[r].begin; s < cells.runs.first[r].end; s += lanes) {
      CentralAndApexes<Floats> own = cell_gradients(cells, s);
#pragma GCC unroll 8
      for (int b = 0; b < 8; ++b) {
        const Floats weight = load(weights + s + corner_offset(b, cells.strides));
        store(result.value[3 * b] + s, weight * own[b].x);
        store(result.value[3 * b + 1] + s, weight * own[b].y);
        store(result.value[3 * b + 2] + s, weight * own[b].z);
      }
    }
}

/// Adds the products over the corners on one side (of z) of a cell and on the matching side of its neighbours
/// in one plane: entry (dx, dy) from the corners b of the cell and c of the neighbour with b − c = (dx, dy).
inline void add_products(const Point<Floats> (&own)[4], const float* const* neighbors, std::int64_t slot,
                         std::int64_t row, Floats (&entries)[9]) {
#pragma GCC unroll 4
  for (int c = 0; c < 4; ++c)
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      const float* from = neighbors[3 * c + axis] + slot;
#pragma GCC unroll 4
      for (int b = 0; b < 4; ++b) {
        const int dx = (b & 1) - (c & 1), dy = (b >> 1) - (c >> 1);
        const Floats& gradient = axis == 0 ? own[b].x : axis == 1 ? own[b].y : own[b].z;
        entries[4 + 3 * dy + dx] += gradient * load(from + dy * row + dx);
      }
    }
}

inline void store_entries(const Floats (&entries)[9], float* const* to, std::int64_t slot) {
#pragma GCC unroll 9
  for (int k = 0; k < 9; ++k) store(to[k] + slot, entries[k]);
}

void assemble(const Cells& cells, Gradients neighbors, Stencil stencil) {
  constexpr int upper = 12;  // the corners 4 to 7
  const auto [row, plane] = cells.strides;
  for (std::int64_t r = 0; r < cells.runs.count; ++r)
    for (std::int64_t s = cells.runs.first[r].begin; s < cells.runs.first[r].end; s += lanes) {
      CentralAndApexes<Floats> own = cell_gradients(cells, s);
      const Point<Floats> low[4] = {own[0], own[1], own[2], own[3]},
                          high[4] = {own[4], own[5], own[6], own[7]};
      Floats below[9] = {}, beside[9] = {}, above[9] = {};
      add_products(low, neighbors.value + upper, s - plane, row, below);
      store_entries(below, stencil.entry, s);
      add_products(low, neighbors.value, s, row, beside);
      add_products(high, neighbors.value + upper, s, row, beside);
      store_entries(beside, stencil.entry + 9, s);
      add_products(high, neighbors.value, s + plane, row, above);
      store_entries(above, stencil.entry + 18, s);
    }
}

void set_scale(Runs runs, const float* diagonal, const float* reference, float smallest, float* scale) {
  constexpr float infinity = __builtin_inff();
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats d = load(diagonal + s), wanted = load(reference + s);
      const FloatMask present = (d > smallest * wanted) & (d < infinity);
      store(scale + s, square_root(present ? wanted / d : Floats{}));
    }
}

float start(Runs runs, const double* errors, const float* scale, float* solution, float* residual,
            float* scaled) {
  Floats worst{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats factor = load(scale + s);
      const Floats error = to_floats(load(errors + s), load(errors + s + double_lanes));
      const Floats rest = factor > 0.0F ? -error : Floats{};
      store(solution + s, Floats{});
      store(residual + s, rest);
      store(scaled + s, factor * rest);
      worst = maximum(worst, absolute(rest));
    }
  return largest(worst);
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

inline Floats checkerboards(const CheckerboardHeights& added, std::int64_t slot) {
  float heights[lanes];
  for (int i = 0; i < lanes; ++i) heights[i] = added.heights[added.blocks[slot + i]];
  return load(added.signs + slot) * load(heights);
}

Products precondition(Runs runs, Direction direction, const float* scale, const float* z,
                      const CheckerboardHeights& added) {
  Floats with_itself{}, with_residual{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      const Floats image = load(direction.image + s), factor = load(scale + s);
      // Not 0·∞ where there is no cell: a solve that overflowed would spoil all that follow.
      Floats scaled = factor * load(direction.preconditioned + s);
      if (added.heights) scaled += checkerboards(added, s);
      scaled = factor > 0.0F ? scaled : Floats{};
      store(direction.preconditioned + s, scaled);
      with_itself += image * scaled;
      with_residual += image * load(z + s);
    }
  return {sum(with_itself), sum(with_residual)};
}

float advance(Runs runs, float alpha, Direction direction, float* solution, float* residual, float* z) {
  Floats worst{};
  for (std::int64_t r = 0; r < runs.count; ++r)
    for (std::int64_t s = runs.first[r].begin; s < runs.first[r].end; s += lanes) {
      store(solution + s, load(solution + s) + alpha * load(direction.search + s));
      store(z + s, load(z + s) - alpha * load(direction.preconditioned + s));
      const Floats rest = load(residual + s) - alpha * load(direction.image + s);
      store(residual + s, rest);
      worst = maximum(worst, absolute(rest));
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
#pragma GCC unroll 8
    for (int j = 0; j < width; ++j) right[j] = load(b + j * lanes);
#pragma GCC unroll 8
    for (int i = 0; i < height; ++i) {
      const Floats left = broadcast(a[i * p.a_row]);
#pragma GCC unroll 8
      for (int j = 0; j < width; ++j) sums[i][j] += left * right[j];
    }
  }
#pragma GCC unroll 8
  for (int i = 0; i < height; ++i)
#pragma GCC unroll 8
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
  if (p.rows == 1)  // as many sums at a time as it takes to wait for none
    for (; column + 8 * lanes <= p.columns; column += 8 * lanes) product_tile<1, 8>(p, 0, column);
  for (; column + 2 * lanes <= p.columns; column += 2 * lanes) product_column<2>(p, column);
  for (; column < p.columns; column += lanes) product_column<1>(p, column);
}

constexpr int longest_axis = 256;

/// Rows of a chunk of columns, on top of each other.
struct Block {
  alignas(64) float values[longest_axis * chunk];
  float* row(int k) { return values + k * chunk; }
};

/// Sums of rows that mirror each other, then their differences.
void fold(const float* from, std::int64_t row, int size, Block& folded) {
  const int half = size / 2, even = size - half;
  for (int i = 0; i < chunk; i += lanes) {
    for (int k = 0; k < half; ++k) {
      const Floats a = load(from + k * row + i), b = load(from + (size - 1 - k) * row + i);
      store(folded.row(k) + i, a + b);
      store(folded.row(even + k) + i, a - b);
    }
    if (even > half) store(folded.row(half) + i, load(from + half * row + i));
  }
}

void unfold(Block& folded, int size, float* to, std::int64_t row) {
  const int half = size / 2, even = size - half;
  for (int i = 0; i < chunk; i += lanes) {
    for (int k = 0; k < half; ++k) {
      const Floats a = load(folded.row(k) + i), b = load(folded.row(even + k) + i);
      store(to + k * row + i, a + b);
      store(to + (size - 1 - k) * row + i, a - b);
    }
    if (even > half) store(to + half * row + i, load(folded.row(half) + i));
  }
}

/// A chunk of columns times the halves of even and odd modes.
void multiply_halves(const float* halves, int size, const float* from, std::int64_t from_row, float* to,
                     std::int64_t to_row) {
  const int odd = size / 2, even = size - odd;
  multiply({halves, even, 1, from, from_row, to, to_row, even, chunk, even});
  multiply({halves + even * even, odd, 1, from + even * from_row, from_row, to + even * to_row, to_row, odd,
            chunk, odd});
}

void to_modes(const ModesProduct& p) {
  const auto& [forward, backward, size, mirrored] = p.modes;
  if (!mirrored)
    return multiply({forward, size, 1, p.from, p.from_row, p.to, p.to_row, size, p.columns, size});
  Block folded;
  for (int column = 0; column < p.columns; column += chunk) {
    fold(p.from + column, p.from_row, size, folded);
    multiply_halves(forward, size, folded.values, chunk, p.to + column, p.to_row);
  }
}

void from_modes(const ModesProduct& p) {
  const auto& [forward, backward, size, mirrored] = p.modes;
  if (!mirrored)
    return multiply({backward, size, 1, p.from, p.from_row, p.to, p.to_row, size, p.columns, size});
  Block folded;
  for (int column = 0; column < p.columns; column += chunk) {
    multiply_halves(backward, size, p.from + column, p.from_row, folded.values, chunk);
    unfold(folded, size, p.to + column, p.to_row);
  }
}

void solve_columns(const ColumnSolve& solve) {
  Block modes;
  for (int column = 0; column < solve.columns; column += chunk) {
    float* values = solve.values + column;
    to_modes({solve.modes, values, solve.stride, modes.values, chunk, chunk});
    for (int k = 0; k < solve.modes.size; ++k)
      for (int i = 0; i < chunk; i += lanes)
        store(modes.row(k) + i,
              load(modes.row(k) + i) * load(solve.inverse_diagonal + column + k * solve.stride + i));
    from_modes({solve.modes, modes.values, chunk, values, solve.stride, chunk});
  }
}

}  // namespace

extern const StencilKernels stencil_kernels_table;
const StencilKernels stencil_kernels_table{gradients, assemble, set_scale,    start,
                                           apply,     combine,  precondition, advance,
                                           multiply,  to_modes, from_modes,   solve_columns};

}  // namespace isochor::newton::ISOCHOR_WIDE
