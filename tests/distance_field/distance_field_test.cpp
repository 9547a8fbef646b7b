#include "core/distance_field/distance_field.h"

#include <gtest/gtest.h>

#include <random>

#include "core/distance_field/closest_point.h"

namespace isochor {
namespace {

TriangleSoup random_soup(unsigned seed, int triangles, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.0, 1.0), offset(-size, size);
  TriangleSoup soup;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 center(place(random), place(random), place(random));
    for (int corner = 0; corner < 3; ++corner)
      soup.positions.push_back(center + Vec3(offset(random), offset(random), offset(random)));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return soup;
}

TEST(DistanceField, AgreesWithBruteForce) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const TriangleSoup soup = random_soup(seed, 60, 0.2);
    Progress progress;
    const DistanceField field = make_distance_field(soup, {24, 4}, progress);
    const Grid& grid = field.grid;
    for (int k = 0; k < grid.size.z(); ++k)
      for (int j = 0; j < grid.size.y(); ++j)
        for (int i = 0; i < grid.size.x(); ++i) {
          const Vec3 x = grid.center(i, j, k);
          double least = 1e300;
          for (const Triangle& t : soup.triangles)
            least = std::min(least, (closest_point_on_triangle(x, soup.positions[t[0]], soup.positions[t[1]],
                                                               soup.positions[t[2]]) -
                                     x)
                                        .norm());
          ASSERT_NEAR(field.distance[grid.index(i, j, k)], least, 1e-5 * grid.spacing)
              << i << " " << j << " " << k;
        }
  }
}

}  // namespace
}  // namespace isochor
