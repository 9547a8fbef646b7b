#pragma once
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/embedding/embedding.h"
#include "core/embedding/triangle_tree.h"

namespace isochor {

/// Per tet: smallest dihedral angle in degrees (0 when not positive) and scaled Jacobian √2·6V over the
/// largest product of the three edges at a vertex (1 for the regular tet; Knupp 2003), negative when
/// inverted.
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

/// soup_tree: over the soup's triangles; made once a soup.
QualitySummary summarize_quality(const TetMesh& mesh, const TriangleSoup& soup, const TriangleTree& soup_tree,
                                 const Embedding& embedding, Progress& progress);

}  // namespace isochor
