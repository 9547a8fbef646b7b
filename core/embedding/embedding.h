#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/common/progress.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Original vertices bound to tets [Milliron 2002]: position = Σ weights[i]·tet vertex i. The weights sum to
/// one (negative ones extrapolate), so affine maps are reproduced exactly.
struct Embedding {
  std::vector<std::int32_t> tet;              ///< a soup vertex
  std::vector<std::array<float, 4>> weights;  ///< of that tet's vertices
  std::int64_t outside = 0;                   ///< vertices outside every tet, bound to the nearest
  double largest_distance = 0.0;              ///< of those, to the tets, in model units
};

Embedding make_embedding(const TriangleSoup& soup, const TetMesh& mesh, Progress& progress);

/// out[v] = Σ weights·positions; sizes as in the embedding.
void apply_embedding(const Embedding& embedding, const TetMesh& mesh, std::span<const Vec3> positions,
                     std::span<Vec3> out);

}  // namespace isochor
