#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Original vertices bound to tets [Milliron 2002]: position = Σ weights[i]·tet vertex i. The weights are
/// multiples of 2⁻⁴⁴, so their sum is exactly one in any order (negative ones extrapolate) and affine maps
/// are reproduced to round-off.
struct Embedding {
  std::vector<std::int32_t> tet;               ///< a soup vertex
  std::vector<std::array<double, 4>> weights;  ///< of that tet's vertices
  std::vector<float> distance;                 ///< to the bound tet in model units; 0 inside
  std::int64_t outside = 0;                    ///< vertices outside every tet, bound to the nearest
  double largest_distance = 0.0;               ///< of those, to the tets, in model units
};

Embedding make_embedding(const TriangleSoup& soup, const TetMesh& mesh, Progress& progress);

/// out[v] = Σ weights·positions; sizes as in the embedding.
void apply_embedding(const Embedding& embedding, const TetMesh& mesh, std::span<const Vec3> positions,
                     std::span<Vec3> out);

}  // namespace isochor
