#pragma once
#include <vector>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Vertices joined by cells, a hinge included: what can be scaled without tearing.
struct VertexComponents {
  std::vector<std::int32_t> of_vertex;
  int count = 0;
};
VertexComponents vertex_components(const TetMesh& mesh);

/// Volume of each component.
std::vector<double> component_volumes(const TetMesh& mesh, const VertexComponents& components);

/// Scales each component about its centroid by cbrt(V0/V) [Desbrun 1999], until its volume is V0 to
/// round-off.
void rescale(const VertexComponents& components, const std::vector<double>& volumes, TetMesh& mesh);

}  // namespace isochor
