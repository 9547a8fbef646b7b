#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh_input/triangle_soup.h"
#include "core/parallel/cancellable_sort.h"

namespace isochor {

/// For each vertex the first one at the same position, no coordinate further off than the tolerance: itself
/// when it has no duplicate before it.
std::vector<std::int32_t> merge_vertices(const std::vector<Vec3>& positions, double tolerance);
/// With the tolerance that closes the seams which exporters leave.
std::vector<std::int32_t> merge_vertices(const TriangleSoup& soup);

/// An undirected edge and how many triangles run along it in each direction.
struct EdgeUse {
  std::int32_t low = 0, high = 0;
  int forward = 0, backward = 0;
};

/// Calls visit(EdgeUse) for each edge once, in ascending order. Sorting the half-edges bounds the time
/// whatever the soup: 10 million triangles take a few seconds.
template <class Visit>
void for_each_edge(const std::vector<Triangle>& triangles, Visit&& visit) {
  struct HalfEdge {
    std::uint64_t key;  ///< low, high, backward
    bool operator<(const HalfEdge& other) const { return key < other.key; }
  };
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::uint64_t>(triangle[i]);
      const auto b = static_cast<std::uint64_t>(triangle[(i + 1) % 3]);
      half_edges.push_back({std::min(a, b) << 33 | std::max(a, b) << 1 | (a > b ? 1U : 0U)});
    }
  cancellable_sort(half_edges);
  for (std::size_t i = 0; i < half_edges.size();) {
    const std::uint64_t edge = half_edges[i].key >> 1;
    EdgeUse use{static_cast<std::int32_t>(edge >> 32), static_cast<std::int32_t>(edge & 0xffffffffU)};
    for (; i < half_edges.size() && half_edges[i].key >> 1 == edge; ++i)
      (half_edges[i].key & 1U) != 0 ? ++use.backward : ++use.forward;
    visit(use);
  }
}

}  // namespace isochor
