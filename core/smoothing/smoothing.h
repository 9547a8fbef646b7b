#pragma once
#include "core/common/progress.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

enum class UmbrellaEdges {
  axis_aligned,  ///< the paper's variant: keeps a symmetric model symmetric
  all,           ///< every boundary edge, to compare (the paper's Figure 2, left)
};

struct SmoothingOptions {
  int iterations = 2;  ///< 0 to 20
  double mu = 0.25;    ///< step of x ← x − μ·U²(x), 0 to 0.4
  UmbrellaEdges edges = UmbrellaEdges::axis_aligned;
  double min_dihedral_deg =
      20.0;  ///< quality floor kept by the limiter; 0 turns it off (inversion never passes)
  bool operator==(const SmoothingOptions&) const = default;
};

struct Smoothed {
  TetMesh mesh;
  /// Relative volume lost before rescaling by a component that holds at least a hundredth of the model; warn
  /// above 0.05.
  double largest_shrinkage = 0.0;
  std::int64_t limited_vertices = 0;
};

/// Second-order Laplacian on boundary vertices [Desbrun 1999], each component rescaled to its volume.
Smoothed smooth(const TetMesh& mesh, const SmoothingOptions& options, Progress& progress);

}  // namespace isochor
