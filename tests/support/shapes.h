#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/mesh_input/triangle_soup.h"

namespace isochor::test {

inline void append(TriangleSoup& soup, const TriangleSoup& other) {
  const auto base = static_cast<std::int32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) soup.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

inline TriangleSoup box(const Vec3& min, const Vec3& max) {
  TriangleSoup soup;
  for (int b = 0; b < 8; ++b)
    soup.positions.emplace_back((b & 1 ? max : min).x(), (b & 2 ? max : min).y(), (b & 4 ? max : min).z());
  for (const auto& q :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    soup.triangles.push_back({q[0], q[1], q[2]});
    soup.triangles.push_back({q[0], q[2], q[3]});
  }
  return soup;
}

/// A grid of nu × nv quads over point(u, v) with u, v in [0, 1], each split in two.
template <class Point>
TriangleSoup patch(int nu, int nv, Point&& point) {
  TriangleSoup soup;
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i)
      soup.positions.push_back(point(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const int a = i + (nu + 1) * j, b = a + 1, c = a + nu + 1, d = c + 1;
      soup.triangles.push_back({a, b, d});
      soup.triangles.push_back({a, d, c});
    }
  return soup;
}

/// From the south pole up to the given share of the height: 1 is the whole sphere, 0.5 an open hemisphere.
inline TriangleSoup sphere(double radius, double share = 1.0, int segments = 64) {
  const double end = std::acos(1.0 - 2.0 * share);
  return patch(segments, segments / 2, [&](double u, double v) {
    const double longitude = 2.0 * std::numbers::pi * u, polar = end * v;
    return Vec3(radius * std::sin(polar) * std::cos(longitude),
                radius * std::sin(polar) * std::sin(longitude), -radius * std::cos(polar));
  });
}

inline TriangleSoup torus(double major, double minor, int segments = 96) {
  return patch(segments, segments / 2, [&](double u, double v) {
    const double a = 2.0 * std::numbers::pi * u, b = 2.0 * std::numbers::pi * v;
    const double r = major + minor * std::cos(b);
    return Vec3(r * std::cos(a), r * std::sin(a), minor * std::sin(b));
  });
}

/// A square sheet of the given side in the plane z = 0, turned by the angle about y.
inline TriangleSoup sheet(double side, double degrees = 0.0, int segments = 16) {
  const double angle = degrees * std::numbers::pi / 180.0;
  return patch(segments, segments, [&](double u, double v) {
    const double x = side * (u - 0.5), y = side * (v - 0.5);
    return Vec3(x * std::cos(angle), y, x * std::sin(angle));
  });
}

}  // namespace isochor::test
