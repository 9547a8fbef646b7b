#include "core/pipeline/soup_size.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace isochor {
namespace {

constexpr int columns_a_side = 64;
/// Crossings closer than this share of the longest edge are one: repeated surfaces.
constexpr double repeated = 1e-6;

struct Crossing {
  std::int32_t column;
  float depth;
  std::int8_t sense;  ///< of the triangle along the column, ±1
  auto operator<=>(const Crossing&) const = default;
};

/// Columns of a square cross-section along `axis`; their centres are off any regular pattern of the input.
struct Columns {
  int axis;
  Vec3 origin;
  double width;

  std::vector<Crossing> crossings(const TriangleSoup& soup) const {
    std::vector<Crossing> found;
    for (const Triangle& t : soup.triangles)
      add(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]], found);
    return found;
  }

 private:
  void add(const Vec3& a, const Vec3& b, const Vec3& c, std::vector<Crossing>& found) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = [&](double low, int along) {
      return static_cast<int>(std::ceil((low - origin[along]) / width));
    };
    const auto last = [&](double high, int along) {
      return static_cast<int>(std::floor((high - origin[along]) / width));
    };
    const int v0 = first(std::min({a[v], b[v], c[v]}), v), v1 = last(std::max({a[v], b[v], c[v]}), v);
    const int u0 = first(std::min({a[u], b[u], c[u]}), u), u1 = last(std::max({a[u], b[u], c[u]}), u);
    for (int j = v0; j <= v1; ++j)
      for (int i = u0; i <= u1; ++i) {
        const double x = origin[u] + i * width, y = origin[v] + j * width;
        const auto side = [&](const Vec3& p, const Vec3& q) {
          return (q[u] - p[u]) * (y - p[v]) - (q[v] - p[v]) * (x - p[u]);
        };
        const double wa = side(b, c), wb = side(c, a), wc = side(a, b), sum = wa + wb + wc;
        if (sum == 0.0 || std::min({wa / sum, wb / sum, wc / sum}) < 0.0) continue;
        found.push_back(
            {j * columns_a_side + i,
             static_cast<float>((wa * a[axis] + wb * b[axis] + wc * c[axis]) / sum - origin[axis]),
             static_cast<std::int8_t>(sum > 0.0 ? 1 : -1)});
      }
  }
};

/// Length between the first crossing of each column and the second, the third and the fourth, …
double inside_length(const std::vector<Crossing>& crossings, double least) {
  double length = 0.0, entered = 0.0;
  bool inside = false;
  for (std::size_t n = 0; n < crossings.size(); ++n) {
    const Crossing& at = crossings[n];
    const bool fresh = n == 0 || crossings[n - 1].column != at.column;
    if (fresh) inside = false;
    if (!fresh && at.depth - crossings[n - 1].depth < least) continue;
    if (inside) length += at.depth - entered;
    inside = !inside;
    entered = at.depth;
  }
  return length;
}

/// Length where the senses of the crossings so far do not cancel out; what a column leaves open does not
/// count.
double wound_length(const std::vector<Crossing>& crossings) {
  double length = 0.0;
  int winding = 0;
  for (std::size_t n = 0; n < crossings.size(); ++n) {
    if (n == 0 || crossings[n - 1].column != crossings[n].column)
      winding = 0;
    else if (winding != 0)
      length += crossings[n].depth - crossings[n - 1].depth;
    winding += crossings[n].sense;
  }
  return length;
}

Vec3 principal_extents(const TriangleSoup& soup, const Vec3& middle) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Vec3 sum = Vec3::Zero();
  const auto for_corners = [&](auto&& visit) {
    for (const Triangle& t : soup.triangles)
      for (const std::int32_t corner : t) visit(Vec3(soup.positions[corner] - middle));
  };
  for_corners([&](const Vec3& x) { sum += x, moments += x * x.transpose(); });
  moments -= sum * sum.transpose() / (3.0 * static_cast<double>(soup.triangles.size()));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments);
  Box box;
  for_corners([&](const Vec3& x) { box.extend(axes.eigenvectors().transpose() * x); });
  return box.size();
}

double median(std::array<double, 3> values) {
  std::ranges::sort(values);
  return values[1];
}

}  // namespace

SoupSize soup_size(const TriangleSoup& soup) {
  SoupSize size;
  size.box = bounding_box(soup);
  size.triangles = static_cast<std::int64_t>(soup.triangles.size());
  size.vertices = static_cast<std::int64_t>(soup.positions.size());
  for (const Triangle& t : soup.triangles)
    size.area += 0.5 * (soup.positions[t[1]] - soup.positions[t[0]])
                           .cross(soup.positions[t[2]] - soup.positions[t[0]])
                           .norm();
  const double longest = size.box.size().maxCoeff(), width = longest / columns_a_side;
  if (!(width > 0.0)) return size;
  size.extents = principal_extents(soup, 0.5 * (size.box.min + size.box.max));
  std::array<double, 3> by_parity{}, by_winding{};
  for (int axis = 0; axis < 3; ++axis) {
    const Columns columns{axis, size.box.min + width * Vec3(0.4142, 0.5321, 0.4679), width};
    std::vector<Crossing> crossings = columns.crossings(soup);
    std::ranges::sort(crossings);
    by_parity[axis] = width * width * inside_length(crossings, repeated * longest);
    by_winding[axis] = width * width * wound_length(crossings);
  }
  size.volume = median(by_parity), size.winding_volume = median(by_winding);
  return size;
}

}  // namespace isochor
