#pragma once
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/distance_field/distance_field.h"
#include "core/embedding/embedding.h"
#include "core/embedding/triangle_tree.h"
#include "core/quality/voxel_distance.h"

namespace isochor {

/// Per tet: smallest dihedral angle in degrees (0 when not positive) and scaled Jacobian √2·6V over the
/// largest product of the three edges at a vertex (1 for the regular tet; Knupp 2003), negative when
/// inverted.
struct TetQuality {
  std::vector<float> min_dihedral_deg, scaled_jacobian;
};
TetQuality tet_quality(std::span<const Vec3> positions, std::span<const Tet> tets);

/// The worst of them, without the arrays.
struct WorstTets {
  double min_dihedral_deg = 180.0, min_scaled_jacobian = 1.0;
  std::int64_t inverted = 0;  ///< or flat
};
WorstTets worst_tets(std::span<const Vec3> positions, std::span<const Tet> tets);

struct QualitySummary {
  double volume = 0.0;
  std::int64_t inverted = 0;
  double min_dihedral_deg = 0.0, min_scaled_jacobian = 0.0;
  /// Share of the soup's area within one cell of the model; below 0.95 the model is reported as incomplete.
  double coverage = 0.0;
  double boundary_to_input = 0.0;  ///< largest distance from the model's boundary vertices to the soup
  /// Share of these vertices farther than a cell's diagonal from the soup: caps of openings, filled pockets.
  double boundary_beyond = 0.0;
  double input_to_boundary = 0.0;  ///< largest distance from the soup's corners and samples to the model
  VoxelDistance to_pseudo_volume;  ///< set apart by the pipeline, which has the pseudo volume
};

/// What the tets alone tell: their volume and the worst of them.
QualitySummary summarize_tets(const TetMesh& mesh, const Progress& progress);

/// What measuring needs of a soup, made once a soup: its triangles' sizes and a tree over them. Keeps a
/// reference to the soup.
struct MeasuredSoup {
  explicit MeasuredSoup(const TriangleSoup& measured);

  const TriangleSoup& soup;
  std::vector<double> area, longest_edge;  ///< a triangle
  double total_area = 0.0, longest = 0.0;
  TriangleTree tree;
};

/// field: the soup's distances, which bound those of the boundary and leave few to the tree.
QualitySummary summarize_quality(const TetMesh& mesh, const MeasuredSoup& input, const Embedding& embedding,
                                 const DistanceField& field, Progress& progress);

}  // namespace isochor
