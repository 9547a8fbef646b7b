#pragma once
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Per tet: smallest dihedral angle in degrees (0 when not positive) and scaled Jacobian (volume over that of
/// the regular tet with the same longest edges; Knupp 2003), negative when inverted.
struct TetQuality {
  std::vector<float> min_dihedral_deg, scaled_jacobian;
};
TetQuality tet_quality(std::span<const Vec3> positions, std::span<const Tet> tets);

struct QualitySummary {
  double volume = 0.0;
  std::int64_t inverted = 0;
  double min_dihedral_deg = 0.0, min_scaled_jacobian = 0.0;
  /// Share of the soup's area within one cell of the model; below 0.95 the model is reported as incomplete.
  double coverage = 0.0;
  double boundary_to_input = 0.0;  ///< largest distance from the model's boundary vertices to the soup
  double input_to_boundary = 0.0;  ///< largest distance from sampled soup points outside the model to it
};
QualitySummary summarize_quality(const TetMesh& mesh, const TriangleSoup& soup, Progress& progress);

}  // namespace isochor
