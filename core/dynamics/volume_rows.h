#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/dynamics/coordinates.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// J of a body's cell volumes at one configuration: row c holds ∂V_c/∂x at its eight corners, in m². An array
/// an entry, cells in lattice order, so that loops along the lattice's rows are wide and need no indices.
class VolumeRows {
 public:
  VolumeRows() = default;
  explicit VolumeRows(const TetMesh& mesh);

  std::size_t size() const { return volumes_.size(); }
  void linearize(const TetMesh& mesh, const Coordinates& positions);
  /// Takes the volumes alone.
  void measure(const TetMesh& mesh, const Coordinates& positions);
  /// m³ a cell, where they were taken last.
  const std::vector<double>& volumes() const { return volumes_; }
  /// product = J·v.
  void multiply(const Coordinates& v, std::vector<double>& product) const;
  /// sum += factor·Jᵀ·multipliers.
  void add_transposed(const std::vector<double>& multipliers, double factor, Coordinates& sum) const;
  /// diagonal = J·diag(d)·Jᵀ's diagonal, d a number an axis of each particle.
  void diagonal(const Coordinates& d, std::vector<double>& diagonal) const;

  std::int64_t bytes() const;

  /// count cells from `first`, whose corners are those of the first one and the vertices that follow them.
  struct CellRun {
    std::int32_t first, count;
    std::array<std::int32_t, 8> corners;
  };

 private:
  std::vector<CellRun> runs_;
  std::array<std::vector<double>, 24> entries_;
  std::vector<double> volumes_;
};

}  // namespace isochor
