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
  static constexpr int lanes = 8;
  struct Node {
    Vec3 min, max;
    std::int32_t first, count;  ///< leaf: index into leaves_; inner: count 0, children first and first + 1
  };
  /// Corners of up to eight triangles, a coordinate a row; spare lanes repeat the first.
  struct Leaf {
    double x[9][lanes];
    std::int32_t triangle[lanes];
  };
  void build(std::int32_t node, std::span<std::int32_t> order, std::span<const std::array<Vec3, 3>> corners);
  void add_leaf(std::int32_t node, std::span<const std::int32_t> order,
                std::span<const std::array<Vec3, 3>> corners);
  static void squared_distances(const Leaf& leaf, const Vec3& p, double* out);

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::vector<std::int32_t> place_;  ///< of each triangle: leaf · lanes + lane
};

}  // namespace isochor
