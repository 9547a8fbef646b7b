#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/types.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// Closest triangle of a set, by a tree of boxes in Morton order, eight children a node. Refers to
/// neither afterwards.
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
  /// Up to eight triangles, each in a frame of its own (rows in the source); spare lanes repeat the first.
  struct Leaf {
    double x[14][lanes];
    std::int32_t triangle[lanes];
  };
  std::vector<Box> add_leaves(std::span<const Vec3> positions, std::span<const Triangle> triangles);
  std::vector<Box> add_parents(std::span<const Box> children, std::int32_t first);
  void improve(Nearest& best, std::int32_t leaf, const Vec3& p) const;

  std::vector<Node> nodes_;  ///< from the leaves' parents up to the root
  std::vector<Leaf> leaves_;
  std::int32_t leaf_parents_ = 0;
  std::vector<std::int32_t> place_;  ///< of each triangle: leaf · lanes + lane
};

}  // namespace isochor
