#include "core/embedding/triangle_tree.h"

#include <algorithm>
#include <array>

#include "core/common/wide.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/parallel/cancellable_range.h"
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
  for (std::int64_t t = 0; t < count; ++t) {
    if (t % 4096 == 0) throw_if_scope_cancelled();
    box.extend(center(t));
  }
  const double longest = box.size().maxCoeff(), scale = longest > 0.0 ? ((1 << 21) - 1) / longest : 0.0;
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys;
  cancellable_resize(keys, static_cast<std::size_t>(count));
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
  for (const auto& [key, triangle] : cancellable(keys)) order.push_back(triangle);
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

/// Rows of a leaf: a corner a, the frame of the triangle (u along its longest edge, from a to b, v in its
/// plane, towards c), the corners b = (length, 0) and c there, and 1 / squared length of bc and ca.
enum Row { ax, ay, az, ux, uy, uz, vx, vy, vz, length, cu, cv, inverse_bc, inverse_ca, rows };

/// Writes the rows of a triangle. One without area lies along u with c between a and b.
void set_lane(const std::array<Vec3, 3>& corners, int lane, double (*x)[8]) {
  const auto edge = [&](int k) -> Vec3 { return corners[(k + 1) % 3] - corners[k]; };
  int k = 0;
  for (int other : {1, 2})
    if (edge(other).squaredNorm() > edge(k).squaredNorm()) k = other;
  const Vec3 ab = edge(k), ac = -edge((k + 2) % 3);
  const double longest = ab.norm();
  const Vec3 u = longest > 0.0 ? Vec3(ab / longest) : Vec3::UnitX();
  const Vec3 across = ac - ac.dot(u) * u;
  const bool has_area = across.norm() > 1e-14 * longest;
  const Vec3 rough = has_area ? across.normalized() : u.unitOrthogonal();
  const Vec3 v = (rough - rough.dot(u) * u).normalized();  // of a sliver, the first time leaves round-off
  const double c_u = ac.dot(u), c_v = std::max(0.0, ac.dot(v));
  const auto inverse = [](double squared) { return squared > 0.0 ? 1.0 / squared : 0.0; };
  const Vec3& a = corners[k];
  const double bc2 = (c_u - longest) * (c_u - longest) + c_v * c_v, ca2 = c_u * c_u + c_v * c_v;
  const double values[rows] = {a.x(), a.y(), a.z(),   u.x(), u.y(), u.z(),        v.x(),
                               v.y(), v.z(), longest, c_u,   c_v,   inverse(bc2), inverse(ca2)};
  for (int row = 0; row < rows; ++row) x[row][lane] = values[row];
}

/// In the triangle's frame: squared distance from (x, y) after the foot on the edge e from the origin.
inline double edge_distance(double x, double y, double eu, double ev, double inverse) {
  const double t = std::min(1.0, std::max(0.0, (x * eu + y * ev) * inverse));
  const double qx = x - t * eu, qy = y - t * ev;
  return qx * qx + qy * qy;
}

// Without branches, so that the loop over the lanes becomes wide: the nearest edge, or the plane where the
// point projects into the triangle.
ISOCHOR_MULTIVERSION void eight_distances(const double (*x)[8], const Vec3& p, double* out) {
  const double px = p.x(), py = p.y(), pz = p.z();
  for (int l = 0; l < 8; ++l) {
    const double r[3]{px - x[ax][l], py - x[ay][l], pz - x[az][l]};
    const double u[3]{x[ux][l], x[uy][l], x[uz][l]}, v[3]{x[vx][l], x[vy][l], x[vz][l]};
    const double pu = r[0] * u[0] + r[1] * u[1] + r[2] * u[2];
    const double pv = r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
    const double height = r[0] * (u[1] * v[2] - u[2] * v[1]) + r[1] * (u[2] * v[0] - u[0] * v[2]) +
                          r[2] * (u[0] * v[1] - u[1] * v[0]);
    const double b = x[length][l], c_u = x[cu][l], c_v = x[cv][l], bc = c_u - b;
    const double off_ab = pu - std::min(b, std::max(0.0, pu));
    const double ab_distance = off_ab * off_ab + pv * pv;
    const double bc_distance = edge_distance(pu - b, pv, bc, c_v, x[inverse_bc][l]);
    const double ca_distance = edge_distance(pu, pv, c_u, c_v, x[inverse_ca][l]);
    const double edges = std::min(ab_distance, std::min(bc_distance, ca_distance));
    const double least_side = std::min(pv, std::min(bc * pv - c_v * (pu - b), c_v * pu - c_u * pv));
    out[l] = height * height + (least_side > 0.0 ? 0.0 : edges);
  }
}

}  // namespace

TriangleTree::TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  if (triangles.empty()) return;
  std::vector<Box> boxes = add_leaves(positions, triangles);
  std::int32_t first = 0;  // of the children
  do {
    const auto parents = static_cast<std::int32_t>(nodes_.size());
    boxes = add_parents(boxes, first);
    first = parents;
    if (leaf_parents_ == 0) leaf_parents_ = static_cast<std::int32_t>(nodes_.size());
  } while (boxes.size() > 1);
}

/// Returns the leaves' boxes.
std::vector<Box> TriangleTree::add_leaves(std::span<const Vec3> positions,
                                          std::span<const Triangle> triangles) {
  const std::vector<std::int32_t> order = morton_order(positions, triangles);
  const auto count = static_cast<std::int32_t>(order.size());
  static_assert(sizeof(Leaf::x) == rows * lanes * sizeof(double));
  cancellable_resize(leaves_, static_cast<std::size_t>((count + lanes - 1) / lanes));
  place_.resize(count);
  std::vector<Box> boxes(leaves_.size());
  parallel_for(static_cast<std::int64_t>(leaves_.size()), 512, [&](std::int64_t begin, std::int64_t end) {
    for (auto n = begin; n < end; ++n)
      for (int l = 0; l < lanes; ++l) {
        const auto at = static_cast<std::int32_t>(n * lanes + l);
        const std::int32_t t = order[at < count ? at : n * lanes];
        const auto& [i, j, k] = triangles[t];
        leaves_[n].triangle[l] = t;
        set_lane({positions[i], positions[j], positions[k]}, l, leaves_[n].x);
        for (const std::int32_t v : triangles[t]) boxes[n].extend(positions[v]);
        if (at < count) place_[t] = at;
      }
  });
  return boxes;
}

/// Of children with these boxes, the first of which has this index. Returns the new nodes' boxes.
std::vector<Box> TriangleTree::add_parents(std::span<const Box> children, std::int32_t first) {
  constexpr double far = 1e300;
  std::vector<Box> boxes;
  for (std::size_t child = 0; child < children.size(); ++child) {
    if (child % 4096 == 0) throw_if_scope_cancelled();
    const int l = static_cast<int>(child % lanes);
    if (l == 0) {
      Node& node = nodes_.emplace_back();
      std::fill_n(&node.min[0][0], 3 * lanes, far), std::fill_n(&node.max[0][0], 3 * lanes, far);
      node.first = first + static_cast<std::int32_t>(child);
      boxes.emplace_back();
    }
    const Box& box = children[child];
    for (int axis = 0; axis < 3; ++axis)
      nodes_.back().min[axis][l] = box.min[axis], nodes_.back().max[axis][l] = box.max[axis];
    boxes.back().extend(box.min), boxes.back().extend(box.max);
  }
  return boxes;
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
