#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// Closest triangle of a set, by a tree of boxes split at the median. Keeps copies of the corners.
class TriangleTree {
 public:
  TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles);

  struct Nearest {
    std::int32_t triangle = -1;  ///< -1: none within the bound
    double squared_distance = 0.0;
  };
  /// The closest triangle nearer than squared_bound.
  Nearest nearest(const Vec3& p, double squared_bound) const;

  /// Squared distance to one triangle of the set.
  double squared_distance(const Vec3& p, std::int32_t triangle) const;

 private:
  struct Node {
    Vec3 min, max;
    std::int32_t first, count;  ///< leaf: triangles; inner: count 0, children first and first + 1
  };
  void build(std::int32_t node, std::int32_t first, std::int32_t count);

  std::vector<Node> nodes_;
  std::vector<std::array<Vec3, 3>> corners_;  ///< in tree order
  std::vector<std::int32_t> order_;           ///< triangle of each place
  std::vector<std::int32_t> place_;           ///< of each triangle
};

}  // namespace isochor
