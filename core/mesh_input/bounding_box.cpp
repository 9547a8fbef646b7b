#include "core/mesh_input/triangle_soup.h"

namespace isochor {

Box bounding_box(const TriangleSoup& soup) {
  Box box;
  for (const Triangle& triangle : soup.triangles)
    for (std::int32_t corner : triangle) box.extend(soup.positions[corner]);
  return box;
}

}  // namespace isochor
