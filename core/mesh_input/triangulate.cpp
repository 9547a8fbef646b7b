#include <algorithm>
#include <array>
#include <cmath>

#include "core/mesh_input/polygon_soup.h"

namespace isochor {
namespace {

using Vec2 = Eigen::Vector2d;

/// Area vector of a polygon, whatever its shape [Newell].
Vec3 area_vector(const std::vector<Vec3>& positions, const Polygon& polygon) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = positions[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (positions[polygon[i]] - origin).cross(positions[polygon[i + 1]] - origin);
  return 0.5 * sum;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Ear clipping in the plane that the polygon is widest in. Its time is bounded: after max_tests point tests
/// the rest is cut as a fan.
class EarClipper {
 public:
  EarClipper(const std::vector<Vec3>& positions, const Polygon& polygon) : polygon_(polygon) {
    const Vec3 normal = area_vector(positions, polygon);
    int drop = 0;
    normal.cwiseAbs().maxCoeff(&drop);
    const int u = (drop + 1) % 3, v = (drop + 2) % 3;
    const double sign = normal[drop] < 0.0 ? -1.0 : 1.0;
    for (std::int32_t corner : polygon) {
      flat_.emplace_back(positions[corner][u], sign * positions[corner][v]);
      ring_.push_back(static_cast<std::int32_t>(ring_.size()));
    }
  }

  void append_triangles(std::vector<Triangle>& triangles) {
    std::size_t candidate = 0, refused = 0;
    while (ring_.size() > 3) {
      const std::size_t n = ring_.size();
      candidate %= n;
      if (refused < n && !is_ear(candidate)) {
        ++candidate, ++refused;
        continue;
      }
      push(triangles, candidate);
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(candidate));
      refused = 0;
    }
    push(triangles, 1);
  }

 private:
  static constexpr std::int64_t max_tests = 20'000'000;

  std::int32_t at(std::size_t i) const { return ring_[i % ring_.size()]; }

  void push(std::vector<Triangle>& triangles, std::size_t tip) const {
    triangles.push_back({polygon_[at(tip + ring_.size() - 1)], polygon_[at(tip)], polygon_[at(tip + 1)]});
  }

  bool is_ear(std::size_t tip) {
    if (tests_ > max_tests) return true;
    const Vec2 &a = flat_[at(tip + ring_.size() - 1)], &b = flat_[at(tip)], &c = flat_[at(tip + 1)];
    ++tests_;
    if (!(turn(a, b, c) > 0.0)) return false;
    for (std::size_t i = tip + 2; i < tip + ring_.size() - 1; ++i) {
      const Vec2& p = flat_[at(i)];
      ++tests_;
      if (p != a && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0)
        return false;
    }
    return true;
  }

  const Polygon& polygon_;
  std::vector<Vec2> flat_;
  std::vector<std::int32_t> ring_;
  std::int64_t tests_ = 0;
};

/// Whether every triangle of the fan from corner 0 points where the whole polygon does.
bool is_fan(const std::vector<Vec3>& positions, const Polygon& polygon) {
  const Vec3 normal = area_vector(positions, polygon);
  const Vec3& origin = positions[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vec3 part = (positions[polygon[i]] - origin).cross(positions[polygon[i + 1]] - origin);
    if (!(part.dot(normal) > 0.0)) return false;
  }
  return true;
}

void append(const std::vector<Vec3>& positions, const Polygon& polygon, std::vector<Triangle>& triangles) {
  if (polygon.size() > 3 && !is_fan(positions, polygon))
    return EarClipper(positions, polygon).append_triangles(triangles);
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
}

}  // namespace

TriangleSoup triangulate(PolygonSoup soup, Progress& progress) {
  TriangleSoup result;
  std::size_t count = 0;
  for (const Polygon& polygon : soup.polygons) count += polygon.size() - 2;
  result.triangles.reserve(count);
  for (std::size_t i = 0; i < soup.polygons.size(); ++i) {
    if (i % 4096 == 0) progress.throw_if_cancelled();
    append(soup.positions, soup.polygons[i], result.triangles);
  }
  result.positions = std::move(soup.positions);
  return result;
}

}  // namespace isochor
