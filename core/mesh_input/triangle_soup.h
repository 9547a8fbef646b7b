#pragma once
#include <vector>

#include "core/common/box.h"

namespace isochor {

/// What a file gives us: positions and index triples; nothing else is assumed. Every index is valid and every
/// coordinate finite; all other defects are information (see inspect.h).
struct TriangleSoup {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

/// Box of the vertices that triangles use.
Box bounding_box(const TriangleSoup& soup);

}  // namespace isochor
