#include "core/distance_field/distance_field.h"
#include "core/parallel/parallel.h"

namespace isochor {

DistanceField thinned(const DistanceField& field, int stride) {
  const Grid& fine = field.grid;
  const Vec3i last = fine.size.array() - 1, count = (last / stride).array() + 1;
  const Vec3i first = (last - stride * (last / stride)) / 2;  // as far from one end as from the other
  const Vec3 corner = Vec3::Constant(0.5 * (1 - stride)) + first.cast<double>();
  DistanceField coarse{{count, stride * fine.spacing, fine.origin + fine.spacing * corner}, {}, 0.0F, 0};
  coarse.max_distance = field.max_distance;
  coarse.padding = (field.padding - first.maxCoeff()) / stride;
  coarse.distance.resize(coarse.grid.count());
  parallel_for(count.z(), 1, [&](std::int64_t begin, std::int64_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k)
      for (int j = 0; j < count.y(); ++j)
        for (int i = 0; i < count.x(); ++i) {
          const Vec3i at = first + stride * Vec3i(i, j, k);
          coarse.distance[coarse.grid.index(i, j, k)] = field.distance[fine.index(at.x(), at.y(), at.z())];
        }
  });
  return coarse;
}

}  // namespace isochor
