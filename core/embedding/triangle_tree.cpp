#include "core/embedding/triangle_tree.h"

#include <algorithm>
#include <numeric>

#include "core/common/wide.h"

namespace isochor {
namespace {

double squared_distance_to_box(const Vec3& p, const Vec3& min, const Vec3& max) {
  return (min - p).cwiseMax(p - max).cwiseMax(0.0).squaredNorm();
}

struct Edge {
  double squared_distance;
  double side;  ///< of the point's projection, times the squared normal; not negative towards the triangle
};

/// Distance to the edge from a along e, r = p − a, n the triangle's normal.
inline Edge edge_distance(const double* e, const double* r, const double* n) {
  const double length2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
  const double along = e[0] * r[0] + e[1] * r[1] + e[2] * r[2];
  const double t = std::min(1.0, std::max(0.0, along / (length2 > 0.0 ? length2 : 1.0)));
  const double qx = r[0] - t * e[0], qy = r[1] - t * e[1], qz = r[2] - t * e[2];
  const double side = (n[1] * e[2] - n[2] * e[1]) * r[0] + (n[2] * e[0] - n[0] * e[2]) * r[1] +
                      (n[0] * e[1] - n[1] * e[0]) * r[2];
  return {qx * qx + qy * qy + qz * qz, side};
}

// Without branches, so that the loop over the lanes becomes wide: the nearest edge, or the plane where the
// point projects into the triangle.
ISOCHOR_MULTIVERSION void eight_distances(const double (*x)[8], const Vec3& p, double* out) {
  const double px = p.x(), py = p.y(), pz = p.z();
  for (int l = 0; l < 8; ++l) {
    const double a[3]{px - x[0][l], py - x[1][l], pz - x[2][l]},
        b[3]{px - x[3][l], py - x[4][l], pz - x[5][l]}, c[3]{px - x[6][l], py - x[7][l], pz - x[8][l]};
    const double ab[3]{a[0] - b[0], a[1] - b[1], a[2] - b[2]}, bc[3]{b[0] - c[0], b[1] - c[1], b[2] - c[2]},
        ca[3]{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double n[3]{ab[1] * bc[2] - ab[2] * bc[1], ab[2] * bc[0] - ab[0] * bc[2],
                      ab[0] * bc[1] - ab[1] * bc[0]};
    const Edge e0 = edge_distance(ab, a, n), e1 = edge_distance(bc, b, n), e2 = edge_distance(ca, c, n);
    const double edges = std::min(e0.squared_distance, std::min(e1.squared_distance, e2.squared_distance));
    const double area2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    const double height = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
    const double plane = height * height / (area2 > 0.0 ? area2 : 1.0);
    const double least_side = std::min(e0.side, std::min(e1.side, e2.side));
    out[l] = (least_side >= 0.0) & (area2 > 0.0) ? std::min(plane, edges) : edges;
  }
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  if (triangles.empty()) return;
  std::vector<std::int32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::array<Vec3, 3>> corners;
  corners.reserve(triangles.size());
  for (const Triangle& t : triangles) corners.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
  place_.resize(triangles.size());
  nodes_.reserve(triangles.size() / 2 + 1);
  nodes_.emplace_back();
  build(0, order, corners);
}

void TriangleTree::build(std::int32_t node, std::span<std::int32_t> order,
                         std::span<const std::array<Vec3, 3>> corners) {
  Vec3 min = Vec3::Constant(1e300), max = Vec3::Constant(-1e300);
  for (const std::int32_t t : order)
    for (const Vec3& corner : corners[t]) min = min.cwiseMin(corner), max = max.cwiseMax(corner);
  nodes_[node] = {min, max, 0, 0};
  if (order.size() <= lanes) return add_leaf(node, order, corners);
  int axis = 0;
  (max - min).maxCoeff(&axis);
  const auto center = [&](std::int32_t t) {
    return corners[t][0][axis] + corners[t][1][axis] + corners[t][2][axis];
  };
  // A multiple of the lanes on the left, so that leaves are full.
  const std::size_t half = (order.size() / 2 + lanes - 1) / lanes * lanes;
  std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(half), {}, center);
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_[node].first = child;
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(child, order.first(half), corners);
  build(child + 1, order.subspan(half), corners);
}

void TriangleTree::add_leaf(std::int32_t node, std::span<const std::int32_t> order,
                            std::span<const std::array<Vec3, 3>> corners) {
  const auto index = static_cast<std::int32_t>(leaves_.size());
  nodes_[node].first = index, nodes_[node].count = static_cast<std::int32_t>(order.size());
  Leaf& leaf = leaves_.emplace_back();
  for (int l = 0; l < lanes; ++l) {
    const std::int32_t t = order[l < static_cast<int>(order.size()) ? l : 0];
    leaf.triangle[l] = t;
    for (int i = 0; i < 9; ++i) leaf.x[i][l] = corners[t][i / 3][i % 3];
    if (l < static_cast<int>(order.size())) place_[t] = index * lanes + l;
  }
}

void TriangleTree::squared_distances(const Leaf& leaf, const Vec3& p, double* out) {
  eight_distances(leaf.x, p, out);
}

double TriangleTree::squared_distance(const Vec3& p, std::int32_t triangle) const {
  const Leaf& leaf = leaves_[place_[triangle] / lanes];
  double distances[lanes];
  squared_distances(leaf, p, distances);
  return distances[place_[triangle] % lanes];
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p, double squared_bound) const {
  Nearest best{-1, squared_bound};
  if (nodes_.empty()) return best;
  std::array<std::pair<double, std::int32_t>, 64> stack;  // the depth is at most log2 of the count
  int top = 0;
  stack[top++] = {squared_distance_to_box(p, nodes_[0].min, nodes_[0].max), 0};
  double distances[lanes];
  while (top > 0) {
    const auto [bound, index] = stack[--top];
    if (bound >= best.squared_distance) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      squared_distances(leaves_[node.first], p, distances);
      for (int l = 0; l < lanes; ++l)
        if (distances[l] < best.squared_distance) best = {leaves_[node.first].triangle[l], distances[l]};
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
