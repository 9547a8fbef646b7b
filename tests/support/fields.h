#pragma once
#include <algorithm>
#include <cmath>
#include <random>

#include "core/distance_field/distance_field.h"

namespace isochor::test {

/// A field on voxels of size 1 whose grid is centred on the origin.
template <class Distance>
DistanceField field_of(const Vec3i& size, Distance&& distance) {
  DistanceField field;
  field.grid = Grid{size, 1.0, -0.5 * size.cast<double>()};
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i)
        field.distance.push_back(static_cast<float>(std::abs(distance(field.grid.center(i, j, k)))));
  field.max_distance = *std::ranges::max_element(field.distance);
  return field;
}

/// No distance field at all: independent values with many ties, for rules that must not depend on that.
inline DistanceField random_field(const Vec3i& size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> value(0, 8);
  return field_of(size, [&](const Vec3&) { return 0.5 * value(random); });
}

/// Distance to random points: a real distance field with crossings in all directions.
inline DistanceField points_field(const Vec3i& size, unsigned seed, int count = 12) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  std::vector<Vec3> points;
  for (int n = 0; n < count; ++n)
    points.push_back(Vec3(place(random), place(random), place(random)).cwiseProduct(size.cast<double>()));
  return field_of(size, [&](const Vec3& x) {
    double least = 1e300;
    for (const Vec3& p : points) least = std::min(least, (x - p).norm());
    return least;
  });
}

inline double box_distance(const Vec3& x, const Vec3& half) {
  const Vec3 q = x.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

}  // namespace isochor::test
