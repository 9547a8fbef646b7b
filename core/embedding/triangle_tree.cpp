#include "core/embedding/triangle_tree.h"

#include <algorithm>
#include <array>

#include "core/common/wide.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/parallel/cancellable_sort.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// Bits of a 21-bit number with two zeros between them.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x1F00000000FFFFU;
  bits = (bits | bits << 16) & 0x1F0000FF0000FFU;
  bits = (bits | bits << 8) & 0x100F00F00F00F00FU;
  bits = (bits | bits << 4) & 0x10C30C30C30C30C3U;
  return (bits | bits << 2) & 0x1249249249249249U;
}

/// Indices of the triangles along a Morton curve through their centres.
std::vector<std::int32_t> morton_order(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  const auto count = static_cast<std::int64_t>(triangles.size());
  const auto center = [&](std::int64_t t) -> Vec3 {
    return (positions[triangles[t][0]] + positions[triangles[t][1]] + positions[triangles[t][2]]) / 3.0;
  };
  Box box;
  for (std::int64_t t = 0; t < count; ++t) box.extend(center(t));
  const double longest = box.size().maxCoeff(), scale = longest > 0.0 ? ((1 << 21) - 1) / longest : 0.0;
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys(count);
  parallel_for(count, 4096, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = begin; t < end; ++t) {
      const Vec3 at = scale * (center(t) - box.min);
      keys[t].first = spread(static_cast<std::uint64_t>(at.x())) |
                      spread(static_cast<std::uint64_t>(at.y())) << 1 |
                      spread(static_cast<std::uint64_t>(at.z())) << 2;
      keys[t].second = static_cast<std::int32_t>(t);
    }
  });
  cancellable_sort(keys);
  std::vector<std::int32_t> order;
  order.reserve(count);
  for (const auto& [key, triangle] : keys) order.push_back(triangle);
  return order;
}

ISOCHOR_MULTIVERSION void eight_box_distances(const double (*min)[8], const double (*max)[8], const Vec3& p,
                                              double* out) {
  const double px = p.x(), py = p.y(), pz = p.z();
  for (int l = 0; l < 8; ++l) {
    const double x = std::max(std::max(min[0][l] - px, px - max[0][l]), 0.0);
    const double y = std::max(std::max(min[1][l] - py, py - max[1][l]), 0.0);
    const double z = std::max(std::max(min[2][l] - pz, pz - max[2][l]), 0.0);
    out[l] = x * x + y * y + z * z;
  }
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
    out[l] = ((least_side >= 0.0) & (area2 > 0.0)) ? std::min(plane, edges) : edges;
  }
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  if (triangles.empty()) return;
  add_leaves(positions, triangles);
  add_parents();
}

void TriangleTree::add_leaves(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  const std::vector<std::int32_t> order = morton_order(positions, triangles);
  const auto count = static_cast<std::int32_t>(order.size());
  leaves_.resize((count + lanes - 1) / lanes);
  place_.resize(count);
  parallel_for(static_cast<std::int64_t>(leaves_.size()), 512, [&](std::int64_t begin, std::int64_t end) {
    for (auto n = begin; n < end; ++n)
      for (int l = 0; l < lanes; ++l) {
        const auto at = static_cast<std::int32_t>(n * lanes + l);
        const std::int32_t t = order[at < count ? at : n * lanes];
        leaves_[n].triangle[l] = t;
        for (int i = 0; i < 9; ++i) leaves_[n].x[i][l] = positions[triangles[t][i / 3]][i % 3];
        if (at < count) place_[t] = at;
      }
  });
}

void TriangleTree::add_parents() {
  constexpr double far = 1e300;
  const auto add_level = [&](std::int32_t first, std::int32_t count, auto&& bound) {
    for (std::int32_t child = 0; child < count; ++child) {
      if (child % lanes == 0) {
        Node& node = nodes_.emplace_back();
        for (int axis = 0; axis < 3; ++axis)
          std::fill_n(node.min[axis], lanes, far), std::fill_n(node.max[axis], lanes, far);
        node.first = first + child;
      }
      for (int axis = 0; axis < 3; ++axis) {
        const auto [min, max] = bound(first + child, axis);
        nodes_.back().min[axis][child % lanes] = min, nodes_.back().max[axis][child % lanes] = max;
      }
    }
  };
  add_level(0, static_cast<std::int32_t>(leaves_.size()), [&](std::int32_t leaf, int axis) {
    double min = far, max = -far;
    for (int corner = axis; corner < 9; corner += 3)
      for (const double x : leaves_[leaf].x[corner]) min = std::min(min, x), max = std::max(max, x);
    return std::pair(min, max);
  });
  leaf_parents_ = static_cast<std::int32_t>(nodes_.size());
  std::int32_t first = 0;
  for (std::int32_t count = leaf_parents_; count > 1;
       count = static_cast<std::int32_t>(nodes_.size()) - first) {
    const std::int32_t children = first;
    first = static_cast<std::int32_t>(nodes_.size());
    add_level(children, count, [&](std::int32_t child, int axis) {
      const Node& node = nodes_[child];
      double min = far, max = -far;
      for (int l = 0; l < lanes && node.min[axis][l] < far; ++l)
        min = std::min(min, node.min[axis][l]), max = std::max(max, node.max[axis][l]);
      return std::pair(min, max);
    });
  }
}

void TriangleTree::improve(Nearest& best, std::int32_t leaf, const Vec3& p) const {
  double distances[lanes];
  eight_distances(leaves_[leaf].x, p, distances);
  for (int l = 0; l < lanes; ++l)
    if (distances[l] < best.squared_distance) best = {leaves_[leaf].triangle[l], distances[l]};
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p, std::int32_t hint) const {
  Nearest best;
  if (nodes_.empty()) return best;
  const std::int32_t tried = hint >= 0 ? place_[hint] / lanes : -1;
  if (tried >= 0) improve(best, tried, p);
  // At most seven siblings wait on each of at most eleven levels; the nearest child is on top.
  struct Entry {
    double bound;
    std::int32_t index;
    bool is_leaf;
  };
  std::array<Entry, 96> stack;
  int top = 0;
  stack[top++] = {0.0, static_cast<std::int32_t>(nodes_.size()) - 1, false};
  double distances[lanes];
  while (top > 0) {
    const auto [bound, index, is_leaf] = stack[--top];
    if (bound >= best.squared_distance) continue;
    if (is_leaf) {
      if (index != tried) improve(best, index, p);
      continue;
    }
    const Node& node = nodes_[index];
    eight_box_distances(node.min, node.max, p, distances);
    const int waiting = top;
    for (int l = 0; l < lanes; ++l) {
      if (distances[l] >= best.squared_distance) continue;
      int at = top++;
      for (; at > waiting && stack[at - 1].bound < distances[l]; --at) stack[at] = stack[at - 1];
      stack[at] = {distances[l], node.first + l, index < leaf_parents_};
    }
  }
  return best;
}

}  // namespace isochor
