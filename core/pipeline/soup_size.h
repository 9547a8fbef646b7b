#pragma once
#include <cstdint>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// What an estimate asks of a soup: its size, not its shape. A few milliseconds for 100,000 triangles.
struct SoupSize {
  Box box;
  Vec3 extents = Vec3::Zero();  ///< of the box along the principal axes of the triangles' corners
  std::int64_t triangles = 0, vertices = 0;
  double area = 0.0;
  /// Inside by the crossings along an axis, the median of the three: by their parity, and by a winding number
  /// that is not zero, which takes shells within shells of the same sense as solid.
  double volume = 0.0, winding_volume = 0.0;
};
SoupSize soup_size(const TriangleSoup& soup);

}  // namespace isochor
