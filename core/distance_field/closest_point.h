#pragma once
#include <algorithm>
#include <array>

#include "core/common/types.h"

namespace isochor {

inline Vec3 closest_point_on_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0.0 ? Vec3(a + std::clamp((x - a).dot(ab) / length2, 0.0, 1.0) * ab) : a;
}

/// Closest point of a triangle, which may be degenerate: the foot on its plane when that lies inside, else
/// the closest of its three edges.
inline Vec3 closest_point_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0) {
    const bool inside = normal.dot((b - a).cross(x - a)) >= 0.0 && normal.dot((c - b).cross(x - b)) >= 0.0 &&
                        normal.dot((a - c).cross(x - c)) >= 0.0;
    if (inside) return x - ((x - a).dot(normal) / area2) * normal;
  }
  const std::array<Vec3, 3> feet{closest_point_on_segment(x, a, b), closest_point_on_segment(x, b, c),
                                 closest_point_on_segment(x, c, a)};
  return *std::min_element(feet.begin(), feet.end(), [&](const Vec3& p, const Vec3& q) {
    return (p - x).squaredNorm() < (q - x).squaredNorm();
  });
}

}  // namespace isochor
