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

/// 27-point symmetric stencil: entry[k] couples a cell with successors[k], entry[0] is the diagonal.
inline constexpr int stencil_size = 14;
struct Neighbor {
  int x, y, z;
  constexpr std::int64_t offset(Strides strides) const { return x + y * strides.row + z * strides.plane; }
};
/// The cell itself and the 13 neighbours that follow it in memory.
inline constexpr Neighbor successors[stencil_size] = {
    {0, 0, 0},  {1, 0, 0},  {-1, 1, 0}, {0, 1, 0}, {1, 1, 0},  {-1, -1, 1}, {0, -1, 1},
    {1, -1, 1}, {-1, 0, 1}, {0, 0, 1},  {1, 0, 1}, {-1, 1, 1}, {0, 1, 1},   {1, 1, 1}};
struct Stencil {
  float* entry[stencil_size];
};
/// A cell's gradient, a float an axis and corner: value[3·corner + axis].
struct Gradients {
  float* value[24];
};

struct ErrorSums {
  double squares, largest, excess;  ///< Σ C², max |C|, Σ (V − V0)
};

/// sign: 1/6 for an even cell, −1/6 for an odd one, 0 where there is none.
struct CellKernels {
  /// errors = V/V0 − 1, inverse_sixfold = sign/V0.
  void (*errors)(Runs runs, Strides strides, Points points, const double* inverse_sixfold, double* errors,
                 ErrorSums* sums);
  /// gradients = √weight(node)·∂V/∂corner, of positions and volumes in units of the length.
  void (*gradients)(Runs runs, Strides strides, Points points, const float* sign, const float* root_weights,
                    double inverse_length, Gradients gradients);
  /// lower, upper += factor·multiplier·∂V/∂corner at the lower and upper four corners.
  void (*forces)(Runs runs, Strides strides, Points points, const float* sign, const float* multipliers,
                 double factor, Points lower, Points upper);
  /// direction = inverse_masses·(lower + upper), which become zero again.
  void (*accelerate)(Runs nodes, const double* inverse_masses, Points lower, Points upper, Points direction);
  /// result = points + t·direction.
  void (*move)(Runs nodes, Points points, double t, Points direction, Points result);
  /// result = (a + b)/2.
  void (*middle)(Runs nodes, Points a, Points b, Points result);
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

/// values = V·diag(d)·Vᵀ·values for a block of columns; every column has its own d.
struct ColumnSolve {
  const float *forward, *backward;  ///< Vᵀ and V, size × size
  const float* inverse_diagonal;
  float* values;
  std::int64_t stride;
  int size, columns;
};

struct DiagonalStep {
  double product;  ///< residual·inverse_diagonal·residual
  float worst;     ///< max |weight·residual|
};

struct StencilKernels {
  /// stencil = Σ over shared corners of the products of gradients.
  void (*assemble)(Runs runs, Strides strides, Gradients gradients, Stencil stencil);
  /// image = A·search; returns search·image.
  double (*apply)(Runs runs, Strides strides, Stencil stencil, const float* search, float* image);
  /// solution += alpha·search, residual −= alpha·image, scaled = scale·residual; returns max
  /// |weight·residual|.
  float (*advance)(Runs runs, float alpha, const float* search, const float* image, const float* scale,
                   const float* weight, float* solution, float* residual, float* scaled);
  /// z = scale·z; returns residual·z.
  double (*precondition)(Runs runs, const float* scale, const float* residual, float* z);
  /// search = z + beta·search.
  void (*turn)(Runs runs, float beta, const float* z, float* search);
  /// The same with the diagonal as preconditioner: solution += alpha·search, residual −= alpha·image; then
  /// turn_diagonal: search = inverse_diagonal·residual + beta·search.
  DiagonalStep (*advance_diagonal)(Runs runs, float alpha, const float* search, const float* image,
                                   const float* inverse_diagonal, const float* weight, float* solution,
                                   float* residual);
  void (*turn_diagonal)(Runs runs, float beta, const float* inverse_diagonal, const float* residual,
                        float* search);
  void (*multiply)(const SmallProduct& product);
  void (*solve_columns)(const ColumnSolve& solve);
};

const CellKernels& cell_kernels();
const StencilKernels& stencil_kernels();

}  // namespace isochor::newton
