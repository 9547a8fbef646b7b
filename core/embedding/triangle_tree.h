#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// Closest triangle of a set, by a tree of boxes in Morton order, eight children a node. Keeps copies of the
/// corners.
class TriangleTree {
 public:
  TriangleTree(std::span<const Vec3> positions, std::span<const Triangle> triangles);

  struct Nearest {
    std::int32_t triangle = -1;  ///< -1: there is none
    double squared_distance = 1e300;
  };
  /// The closest triangle. hint: one that is likely near, or -1.
  Nearest nearest(const Vec3& p, std::int32_t hint = -1) const;

 private:
  static constexpr int lanes = 8;
  /// Boxes of up to eight children, a coordinate a row; spare lanes are infinitely far from everything.
  struct Node {
    double min[3][lanes], max[3][lanes];
    std::int32_t first;  ///< of the children: nodes, or leaves below leaf_parents_
  };
  /// Corners of up to eight triangles, a coordinate a row; spare lanes repeat the first.
  struct Leaf {
    double x[9][lanes];
    std::int32_t triangle[lanes];
  };
  void add_leaves(std::span<const Vec3> positions, std::span<const Triangle> triangles);
  void add_parents();
  void improve(Nearest& best, std::int32_t leaf, const Vec3& p) const;

  std::vector<Node> nodes_;  ///< from the leaves' parents up to the root
  std::vector<Leaf> leaves_;
  std::int32_t leaf_parents_ = 0;
  std::vector<std::int32_t> place_;  ///< of each triangle: leaf · lanes + lane
};

}  // namespace isochor
