#include "core/embedding/triangle_tree.h"

#include <algorithm>
#include <numeric>

#include "core/distance_field/closest_point.h"

namespace isochor {
namespace {

constexpr std::int32_t leaf_size = 4;

double squared_distance_to_box(const Vec3& p, const Vec3& min, const Vec3& max) {
  return (min - p).cwiseMax(p - max).cwiseMax(0.0).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  order_.resize(triangles.size());
  std::iota(order_.begin(), order_.end(), 0);
  corners_.reserve(triangles.size());
  for (const Triangle& t : triangles) corners_.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
  if (triangles.empty()) return;
  nodes_.reserve(2 * triangles.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(triangles.size()));
  std::vector<std::array<Vec3, 3>> sorted(corners_.size());
  place_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    sorted[i] = corners_[order_[i]];
    place_[order_[i]] = static_cast<std::int32_t>(i);
  }
  corners_.swap(sorted);
}

void TriangleTree::build(std::int32_t node, std::int32_t first, std::int32_t count) {
  Vec3 min = Vec3::Constant(1e300), max = Vec3::Constant(-1e300);
  for (std::int32_t i = first; i < first + count; ++i)
    for (const Vec3& corner : corners_[order_[i]]) min = min.cwiseMin(corner), max = max.cwiseMax(corner);
  nodes_[node] = {min, max, first, count};
  if (count <= leaf_size) return;
  int axis = 0;
  (max - min).maxCoeff(&axis);
  const auto center = [&](std::int32_t t) {
    return corners_[t][0][axis] + corners_[t][1][axis] + corners_[t][2][axis];
  };
  const auto begin = order_.begin() + first;
  const std::int32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count,
                   [&](std::int32_t a, std::int32_t b) { return center(a) < center(b); });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_[node].first = child, nodes_[node].count = 0;
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(child, first, half);
  build(child + 1, first + half, count - half);
}

double TriangleTree::squared_distance(const Vec3& p, std::int32_t triangle) const {
  const auto& t = corners_[place_[triangle]];
  return (closest_point_on_triangle(p, t[0], t[1], t[2]) - p).squaredNorm();
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p, double squared_bound) const {
  Nearest best{-1, squared_bound};
  if (nodes_.empty()) return best;
  std::array<std::pair<double, std::int32_t>, 64> stack;  // depth is at most log2 of the count
  int top = 0;
  stack[top++] = {squared_distance_to_box(p, nodes_[0].min, nodes_[0].max), 0};
  while (top > 0) {
    const auto [bound, index] = stack[--top];
    if (bound >= best.squared_distance) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const auto& t = corners_[i];
        const double d = (closest_point_on_triangle(p, t[0], t[1], t[2]) - p).squaredNorm();
        if (d < best.squared_distance) best = {order_[i], d};
      }
      continue;
    }
    const Node &left = nodes_[node.first], &right = nodes_[node.first + 1];
    const double dl = squared_distance_to_box(p, left.min, left.max);
    const double dr = squared_distance_to_box(p, right.min, right.max);
    const std::int32_t near = dl <= dr ? node.first : node.first + 1;
    stack[top++] = {std::max(dl, dr), 2 * node.first + 1 - near};
    stack[top++] = {std::min(dl, dr), near};
  }
  return best;
}

}  // namespace isochor
