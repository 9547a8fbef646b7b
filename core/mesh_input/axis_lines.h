#pragma once
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// Parallel lines along an axis, a square grid of them across it: line (i, j) passes through origin +
/// spacing·(i, j), i along the axis that comes next and j along the one after. Origins off any regular
/// pattern of a soup keep the lines off its edges.
class AxisLines {
 public:
  AxisLines(int axis, const Vec3& origin, double spacing) : axis_(axis), origin_(origin), spacing_(spacing) {}

  /// How many lines the boxes of all triangles hold.
  std::int64_t tries(const TriangleSoup& soup) const {
    std::int64_t sum = 0;
    for (const Triangle& t : soup.triangles)
      sum += span(soup, t, across()).count() * span(soup, t, up()).count();
    return sum;
  }

  /// Calls visit(i, j, depth, sense) for the lines that pass through a triangle: the depth from the origin,
  /// and ±1 by the side from which they do. A closed surface is entered as often as it is left.
  template <class Visit>
  void for_crossings(const TriangleSoup& soup, const Triangle& t, Visit&& visit) const {
    const Vec3 &a = soup.positions[t[0]], &b = soup.positions[t[1]], &c = soup.positions[t[2]];
    const Span columns = span(soup, t, across()), rows = span(soup, t, up());
    for (int j = rows.first; j <= rows.last; ++j)
      for (int i = columns.first; i <= columns.last; ++i) {
        const double x = origin_[across()] + i * spacing_, y = origin_[up()] + j * spacing_;
        const double wa = side(b, c, x, y), wb = side(c, a, x, y), wc = side(a, b, x, y);
        const bool left = wa > 0.0 && wb > 0.0 && wc > 0.0, right = wa < 0.0 && wb < 0.0 && wc < 0.0;
        if (!left && !right) continue;
        const double depth = (wa * a[axis_] + wb * b[axis_] + wc * c[axis_]) / (wa + wb + wc);
        visit(i, j, depth - origin_[axis_], left ? 1 : -1);
      }
  }

 private:
  int across() const { return (axis_ + 1) % 3; }
  int up() const { return (axis_ + 2) % 3; }

  struct Span {
    int first, last;
    std::int64_t count() const { return std::max(0, last - first + 1); }
  };
  Span span(const TriangleSoup& soup, const Triangle& t, int along) const {
    const double a = soup.positions[t[0]][along], b = soup.positions[t[1]][along],
                 c = soup.positions[t[2]][along];
    return {static_cast<int>(std::ceil((std::min({a, b, c}) - origin_[along]) / spacing_)),
            static_cast<int>(std::floor((std::max({a, b, c}) - origin_[along]) / spacing_))};
  }

  /// On which side of the edge from p to q the line at (x, y) passes: never on it, and for q to p exactly on
  /// the other.
  double side(const Vec3& p, const Vec3& q, double x, double y) const {
    const int u = across(), v = up();
    const bool turned = std::tie(q[u], q[v]) < std::tie(p[u], p[v]);
    const Vec3 &from = turned ? q : p, &to = turned ? p : q;
    const double area = (to[u] - from[u]) * (y - from[v]) - (to[v] - from[v]) * (x - from[u]);
    const double decided = area != 0.0 ? area : 1e-300;
    return turned ? -decided : decided;
  }

  int axis_;
  Vec3 origin_;
  double spacing_;
};

}  // namespace isochor
