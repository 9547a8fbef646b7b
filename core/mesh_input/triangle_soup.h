#pragma once
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// What a file gives us: positions and index triples; nothing else is assumed. Every index is valid and every
/// coordinate finite; all other defects are information (see inspect.h).
struct TriangleSoup {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

struct Box {
  Vec3 min = Vec3::Constant(1e300), max = Vec3::Constant(-1e300);
  void extend(const Vec3& p) { min = min.cwiseMin(p), max = max.cwiseMax(p); }
  Vec3 size() const { return max - min; }
  Vec3 center() const { return 0.5 * (min + max); }
};

/// Box of the vertices that triangles use.
Box bounding_box(const TriangleSoup& soup);

}  // namespace isochor
