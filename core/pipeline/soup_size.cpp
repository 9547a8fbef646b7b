#include "core/pipeline/soup_size.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh_input/columns.h"
#include "core/parallel/cancellable_range.h"

namespace isochor {
namespace {

using Crossing = Columns::Crossing;

/// Crossings closer than this share of the longest edge are one: repeated surfaces.
constexpr double repeated = 1e-6;

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
    for (const Triangle& t : cancellable(soup.triangles))
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
  for (const Triangle& t : cancellable(soup.triangles))
    size.area += 0.5 * (soup.positions[t[1]] - soup.positions[t[0]])
                           .cross(soup.positions[t[2]] - soup.positions[t[0]])
                           .norm();
  const double longest = size.box.size().maxCoeff();
  if (!(0.01 * longest > 0.0)) return size;
  size.extents = principal_extents(soup, 0.5 * (size.box.min + size.box.max));
  std::array<double, 3> volumes{};
  for (int axis = 0; axis < 3; ++axis) {
    const Columns columns(soup, size.box, axis);
    volumes[axis] = columns.area() * inside_length(columns.crossings(soup), repeated * longest);
  }
  size.volume = median(volumes);
  return size;
}

double wound_volume(const TriangleSoup& soup) {
  const Box box = bounding_box(soup);
  std::array<double, 3> volumes{};
  for (int axis = 0; axis < 3; ++axis) {
    const Columns columns(soup, box, axis);
    volumes[axis] = columns.area() * wound_length(columns.crossings(soup));
  }
  return median(volumes);
}

}  // namespace isochor
