#pragma once
#include <cstdint>

/// The inner loops of the Newton projection, compiled once for each instruction set and chosen at run time.
/// These files include nothing of the standard library but integers, lest a function compiled for one machine
/// be linked into code for another.
namespace isochor::newton {

/// Offsets to the next row and plane of a lattice whose cells and nodes share one flat array: the cell at
/// slot s has its corner b at slot s + (b&1) + (b>>1&1)·row + (b>>2&1)·plane.
struct Strides {
  std::int64_t row, plane;
};

/// Slots [begin, end), both multiples of chunk.
struct Run {
  std::int32_t begin, end;
};
struct Runs {
  const Run* first;
  std::int64_t count;
};
inline constexpr int chunk = 16;

struct Points {
  double *x, *y, *z;
};

struct Neighbor {
  int x, y, z;
  constexpr std::int64_t offset(Strides strides) const { return x + y * strides.row + z * strides.plane; }
};
/// The 27 cells around a cell, in the order of memory.
inline constexpr int stencil_size = 27, stencil_center = 13;
constexpr Neighbor neighbor(int k) {
  return {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
}
/// entry[k] couples a cell with neighbor(k).
struct Stencil {
  float* entry[stencil_size];
};
/// A cell's gradient, a float an axis and corner: value[3·corner + axis].
struct Gradients {
  float* value[24];
};

struct ErrorSums {
  double squares, largest, excess;  ///< Σ C², max |C|, Σ (V − V0)
  double smallest_tet;              ///< min of V_t/V0
};

/// In double. sign: positive for an even cell, negative for an odd one, 0 where there is none (or an
/// irregular one); a sixth of the factor that the volume is taken with.
struct CellKernels {
  /// errors = V/V0 − 1, inverse_volumes = ±1/(6·V0).
  void (*errors)(Runs runs, Strides strides, Points points, const double* inverse_volumes, double* errors,
                 ErrorSums* sums);
  /// forces += 6·sign·factor·multiplier·∂V/∂corner.
  void (*forces)(Runs runs, Strides strides, Points points, const float* sign, const float* multipliers,
                 double factor, Points forces);
  /// direction = inverse_masses·forces, result = points + direction; the forces become zero again.
  void (*accelerate)(Runs nodes, const double* inverse_masses, Points forces, Points direction, Points points,
                     Points result);
  /// result = points + t·direction.
  void (*move)(Runs nodes, Points points, double t, Points direction, Points result);
};

/// C = A·B; the columns of B and C are contiguous and a multiple of chunk.
struct SmallProduct {
  const float* a;
  std::int64_t a_row, a_column;
  const float* b;
  std::int64_t b_row;
  float* c;
  std::int64_t c_row;
  int rows, columns, inner;
};

/// The eigenvectors V of an axis. Of an axis that is its own mirror image they are even or odd, and half of
/// each is enough: first the even ones, (size+1)/2 of them, then the odd ones.
struct Modes {
  const float *forward,
      *backward;  ///< Vᵀ and V; when mirrored, halves of the even ones, then of the odd ones
  int size;
  bool mirrored;
};
/// to = Vᵀ·from or V·from; columns are contiguous and a multiple of chunk.
struct ModesProduct {
  Modes modes;
  const float* from;
  std::int64_t from_row;
  float* to;
  std::int64_t to_row;
  int columns;
};

/// values = V·diag(d)·Vᵀ·values for a block of columns; every column has its own d.
struct ColumnSolve {
  Modes modes;
  const float* inverse_diagonal;
  float* values;
  std::int64_t stride;
  int columns;
};

/// A search direction s of the conjugate residuals, its image A·s, and that preconditioned.
struct Direction {
  float *search, *image, *preconditioned;
};
inline constexpr int depth = 2;  ///< earlier directions to which a new one is made orthogonal
struct EarlierDirections {
  Direction at[depth];
  int count;
};
struct Products {
  double with_itself, with_residual;  ///< image·preconditioned, image·(preconditioned residual)
};

/// Checkerboards that are added to what the diagonal preconditions: sign·height of a slot's block; none where
/// there are no heights.
struct CheckerboardHeights {
  const std::int32_t* blocks;
  const float *signs, *heights;
};

/// Points in double, lengths to be taken in units of 1/inverse_length; sign as for CellKernels.
struct Cells {
  Runs runs;
  Strides strides;
  Points points;
  const float* sign;
  double inverse_length;
};

/// In float.
struct StencilKernels {
  /// gradients = 6·sign·weight(node)·∂V/∂corner.
  void (*gradients)(const Cells& cells, const float* weights, Gradients gradients);
  /// stencil = Σ over shared corners of 6·sign·∂V/∂corner times the gradients given.
  void (*assemble)(const Cells& cells, Gradients gradients, Stencil stencil);
  /// scale = √(reference/diagonal), 0 where the diagonal is not above smallest·reference.
  void (*set_scale)(Runs runs, const float* diagonal, const float* reference, float smallest, float* scale);
  /// residual = −errors where there is a scale, solution = 0, scaled = scale·residual; returns max
  /// |residual|.
  float (*start)(Runs runs, const double* errors, const float* scale, float* solution, float* residual,
                 float* scaled);
  /// image = A·z, products[i] = image·earlier.at[i].preconditioned.
  void (*apply)(Runs runs, Strides strides, Stencil stencil, const float* z, float* image,
                const EarlierDirections& earlier, double* products);
  /// direction = (z, image) − Σ factors[i]·earlier[i], scaled = scale·image; the image is in its place
  /// before.
  void (*combine)(Runs runs, const EarlierDirections& earlier, const float* factors, const float* z,
                  Direction direction, const float* scale, float* scaled);
  /// preconditioned = scale·preconditioned, and the checkerboards.
  Products (*precondition)(Runs runs, Direction direction, const float* scale, const float* z,
                           const CheckerboardHeights& added);
  /// solution += alpha·search, residual −= alpha·image, z −= alpha·preconditioned; returns max |residual|.
  float (*advance)(Runs runs, float alpha, Direction direction, float* solution, float* residual, float* z);
  void (*multiply)(const SmallProduct& product);
  void (*to_modes)(const ModesProduct& product);
  void (*from_modes)(const ModesProduct& product);
  void (*solve_columns)(const ColumnSolve& solve);
};

const CellKernels& cell_kernels();
const StencilKernels& stencil_kernels();

}  // namespace isochor::newton
