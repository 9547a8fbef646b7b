#include "core/mesh_input/triangle_soup.h"

namespace isochor {

Box bounding_box(const TriangleSoup& soup) {
  std::vector<std::uint8_t> used(soup.positions.size(), 0);
  for (const Triangle& triangle : soup.triangles)
    for (const std::int32_t corner : triangle) used[corner] = 1;
  Box box;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) box.extend(soup.positions[v]);
  return box;
}

}  // namespace isochor
