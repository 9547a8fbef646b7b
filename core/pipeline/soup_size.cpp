#include "core/pipeline/soup_size.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh_input/axis_lines.h"
#include "core/parallel/cancellable_sort.h"

namespace isochor {
namespace {

constexpr int most_columns_a_side = 64;
/// Of all triangles' columns; beyond, columns are fewer: millions of large triangles over each other would
/// cross thousands of columns each, and fill any memory.
constexpr std::int64_t max_tries = 4'000'000, tries_a_triangle = 4;
/// Crossings closer than this share of the longest edge are one: repeated surfaces.
constexpr double repeated = 1e-6;

struct Crossing {
  std::int32_t column;
  float depth;
  std::int8_t sense;  ///< of the triangle along the column, ±1
  auto operator<=>(const Crossing&) const = default;
};

/// Columns of a square cross-section along `axis`; their centres are off any regular pattern of the input.
class Columns {
 public:
  Columns(const Box& box, int axis, int a_side)
      : a_side_(a_side),
        width_(box.size().maxCoeff() / a_side),
        lines_(axis, box.min + width_ * Vec3(0.4142, 0.5321, 0.4679), width_) {}

  double area() const { return width_ * width_; }
  std::int64_t tries(const TriangleSoup& soup) const { return lines_.tries(soup); }
  std::vector<Crossing> crossings(const TriangleSoup& soup) const {
    std::vector<Crossing> found;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      if (t % 4096 == 0) throw_if_scope_cancelled();
      lines_.for_crossings(soup, soup.triangles[t], [&](int i, int j, double depth, int sense) {
        found.push_back({j * a_side_ + i, static_cast<float>(depth), static_cast<std::int8_t>(sense)});
      });
    }
    return found;
  }

 private:
  int a_side_;
  double width_;
  AxisLines lines_;
};

Columns affordable_columns(const TriangleSoup& soup, const Box& box, int axis) {
  const std::int64_t affordable =
      max_tries + tries_a_triangle * static_cast<std::int64_t>(soup.triangles.size());
  for (int a_side = most_columns_a_side;; a_side /= 2)
    if (const Columns columns(box, axis, a_side); a_side == 1 || columns.tries(soup) <= affordable)
      return columns;
}

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
  const double longest = size.box.size().maxCoeff();
  if (!(longest / most_columns_a_side > 0.0)) return size;
  size.extents = principal_extents(soup, 0.5 * (size.box.min + size.box.max));
  std::array<double, 3> by_parity{}, by_winding{};
  for (int axis = 0; axis < 3; ++axis) {
    const Columns columns = affordable_columns(soup, size.box, axis);
    std::vector<Crossing> crossings = columns.crossings(soup);
    cancellable_sort(crossings);
    by_parity[axis] = columns.area() * inside_length(crossings, repeated * longest);
    by_winding[axis] = columns.area() * wound_length(crossings);
  }
  size.volume = median(by_parity), size.winding_volume = median(by_winding);
  return size;
}

}  // namespace isochor
