#pragma once
#include <string>
#include <vector>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

struct Tets {
  std::vector<Vec3> positions;
  std::vector<Tet> tets;
};

/// What a user would otherwise take from Debian (both AGPL or GPL: benchmarks only). `spacing` is the edge
/// length to aim at. They throw std::runtime_error with their own reason.
Tets tetgen_tets(const TriangleSoup& soup, double spacing);
/// CGAL's alpha wrap, alpha = spacing and offset = spacing / 30 as its manual proposes, then Mesh_3.
Tets alpha_wrap_tets(const TriangleSoup& soup, double spacing);

}  // namespace isochor
