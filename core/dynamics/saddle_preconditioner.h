#pragma once
#include <optional>
#include <vector>

#include "core/dynamics/box_transform.h"
#include "core/dynamics/spring_tangent.h"

namespace isochor {

/// Inverses of A and of S = J A⁻¹ Jᵀ for a full box of equal cells at rest, on the bounding box of any body.
/// With D = diag(1, 2, …, 2, 1) and N the adjacency of an axis' nodes, masses are D⊗D⊗D, edges along x
/// (D − N)⊗D⊗D and all four diagonals D⊗D⊗D − N⊗N⊗N; N v = cos θ·D v diagonalises all of them at once. What
/// the diagonals couple between x, y and z is left out of A's inverse. S takes each mode's A for its own,
/// S(θ) = Σ_d α λ_d/A_d(θ), λ_d = 4 tan²(θ_d/2) of the volume's rows (FastDiagonalization).
class BoxPreconditioner {
 public:
  static constexpr int longest = 255;  ///< cells an axis

  /// Nothing where two vertices share a lattice node, or the box is too long.
  static std::optional<BoxPreconditioner> make(const TetMesh& mesh);

  /// area: of a cell's face, m².
  void prepare(const MeanStiffness& mean, double area);
  /// to = A⁻¹·from.
  void nodes(const Coordinates& from, Coordinates& to);
  /// to = S⁻¹·from.
  void cells(const std::vector<double>& from, std::vector<double>& to);
  /// The body fills its bounding box.
  bool fits() const { return fits_; }
  std::int64_t bytes() const;

 private:
  explicit BoxPreconditioner(const TetMesh& mesh);
  void apply(const BoxTransform& transform, const std::vector<std::int32_t>& slots, double scale,
             const double* from, double* to, float* values) const;

  bool fits_ = false;
  std::vector<std::int32_t> node_slots_, cell_slots_;
  std::array<std::vector<double>, 3> node_cosines_, cell_cosines_, eigenvalues_;
  std::vector<BoxTransform> node_transforms_;          ///< of x, y and z
  std::vector<BoxTransform> cell_transform_;           ///< one
  double node_scale_ = 0.0, cell_scale_ = 0.0;         ///< float weights are relative to these
  std::array<newton::AlignedArray<float>, 3> values_;  ///< an axis
};

}  // namespace isochor
