#include "core/pseudo_volume/directions.h"

#include <algorithm>
#include <vector>

namespace isochor {

std::span<const Vec3i> ray_directions() {
  static const std::vector<Vec3i> directions = [] {
    std::vector<Vec3i> all;
    for (const int length : {1, 3, 2})  // squared: axes, space diagonals, face diagonals
      for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
          for (int x = -1; x <= 1; ++x)
            if (x * x + y * y + z * z == length) all.emplace_back(x, y, z);
    return all;
  }();
  return directions;
}

}  // namespace isochor
