#pragma once
#include <cstdint>
#include <vector>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

struct SelfIntersections {
  std::int64_t pairs = 0;       ///< of triangles without a common vertex that meet
  std::vector<Vec3> locations;  ///< of the first few
  bool complete = true;         ///< false where triangles crowd so much that not all pairs were tried
};

/// Triangles in one plane do not count. Time grows with the triangles, not with their pairs: where
/// too many share a place, only some pairs are tried.
SelfIntersections find_self_intersections(const std::vector<Vec3>& positions,
                                          const std::vector<Triangle>& triangles, std::size_t max_locations);

}  // namespace isochor
