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
  double volume = 0.0;  ///< inside by the parity of crossings along an axis, the median of the three
};
SoupSize soup_size(const TriangleSoup& soup);

/// Where the senses of the crossings along an axis do not cancel out, the median of the three: shells within
/// shells of the same sense are solid.
double wound_volume(const TriangleSoup& soup);

}  // namespace isochor
