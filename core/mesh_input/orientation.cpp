#include "core/mesh_input/orientation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/mesh_input/columns.h"
#include "core/mesh_input/topology.h"

namespace isochor {
namespace {

void turn(Triangle& t) {
  std::swap(t[0], t[1]);
}

bool has_three_corners(const Triangle& t) {
  return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

std::vector<Triangle> merged_triangles(const TriangleSoup& soup) {
  const std::vector<std::int32_t> first = merge_vertices(soup);
  std::vector<Triangle> triangles = soup.triangles;
  for (Triangle& t : triangles) t = {first[t[0]], first[t[1]], first[t[2]]};
  return triangles;
}

/// Sets of triangles that are known to face alike or against each other [union-find with parity].
class Facing {
 public:
  explicit Facing(std::size_t count) : parent_(count), against_(count, false) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  struct Root {
    std::int32_t triangle;
    bool against;
  };
  Root root(std::int32_t t) {
    bool against = false;
    std::int32_t top = t;
    for (; parent_[top] != top; top = parent_[top]) against ^= against_[top];
    for (bool rest = against; t != top;) {  // shortens the way for the next time
      const bool step = against_[t];
      against_[t] = rest, rest ^= step;
      t = std::exchange(parent_[t], top);
    }
    return {top, against};
  }
  /// Whether that contradicts nothing known.
  bool unite(std::int32_t s, std::int32_t t, bool against) {
    const Root a = root(s), b = root(t);
    if (a.triangle == b.triangle) return (a.against ^ b.against) == against;
    parent_[a.triangle] = b.triangle, against_[a.triangle] = a.against ^ b.against ^ against;
    return true;
  }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<bool> against_;
};

struct HalfEdge {
  std::uint64_t edge;
  std::int32_t triangle;
  bool backward;
  bool operator<(const HalfEdge& other) const { return edge < other.edge; }
};

std::vector<HalfEdge> sorted_half_edges(const std::vector<Triangle>& triangles) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!has_three_corners(triangles[t])) continue;
    for (int i = 0; i < 3; ++i) {
      const auto a = static_cast<std::uint64_t>(triangles[t][i]),
                 b = static_cast<std::uint64_t>(triangles[t][(i + 1) % 3]);
      half_edges.push_back({std::min(a, b) << 32 | std::max(a, b), static_cast<std::int32_t>(t), a > b});
    }
  }
  cancellable_sort(half_edges);
  return half_edges;
}

bool join_neighbours(const std::vector<HalfEdge>& half_edges, Facing& facing) {
  for (std::size_t i = 0; i < half_edges.size(); i += 2) {
    if (i + 1 == half_edges.size() || half_edges[i].edge != half_edges[i + 1].edge) return false;
    if (i + 2 < half_edges.size() && half_edges[i].edge == half_edges[i + 2].edge) return false;
    const HalfEdge &one = half_edges[i], &other = half_edges[i + 1];
    if (!facing.unite(one.triangle, other.triangle, one.backward == other.backward)) return false;
  }
  return true;
}

/// The part of each triangle: those that share vertices.
std::vector<std::int32_t> parts_of(const TriangleSoup& soup, int& count) {
  const std::vector<Triangle> triangles = merged_triangles(soup);
  std::vector<std::int32_t> parent(soup.positions.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) parent[root(v)] = root(t[0]);
  std::vector<std::int32_t> number(parent.size(), -1), part(triangles.size());
  count = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::int32_t& n = number[root(triangles[t][0])];
    if (n < 0) n = count++;
    part[t] = n;
  }
  return part;
}

/// Of the tetrahedron between a triangle and a point.
double volume_to(const TriangleSoup& soup, const Triangle& t, const Vec3& point) {
  const auto at = [&](int i) { return Vec3(soup.positions[t[i]] - point); };
  return at(0).dot(at(1).cross(at(2))) / 6.0;
}

std::vector<double> signed_volumes(const TriangleSoup& soup, const Vec3& center,
                                   const std::vector<std::int32_t>& part, int parts) {
  std::vector<double> volumes(parts, 0.0);
  for (std::size_t t = 0; t < part.size(); ++t)
    volumes[part[t]] += volume_to(soup, soup.triangles[t], center);
  return volumes;
}

/// For each part those that it is within wherever a column crosses it.
std::vector<std::vector<std::int32_t>> containers(const TriangleSoup& soup, const Box& box,
                                                  const std::vector<std::int32_t>& part, int parts) {
  std::vector<std::vector<std::int32_t>> around(parts);
  std::vector<std::uint8_t> seen(parts, 0);
  std::vector<int> windings(parts, 0);
  std::vector<std::int32_t> entered;
  std::int32_t column = -1;
  for (const Columns::Crossing& at : Columns(soup, box, 0).crossings(soup)) {
    if (at.column != column) {
      for (const std::int32_t p : entered) windings[p] = 0;
      entered.clear();
      column = at.column;
    }
    const std::int32_t p = part[at.triangle];
    if (seen[p] == 0) around[p] = entered;
    seen[p] = 1;
    std::erase_if(around[p], [&](std::int32_t other) { return other == p || windings[other] == 0; });
    if (windings[p] == 0) entered.push_back(p);
    windings[p] += at.sense;
    if (windings[p] == 0) std::erase(entered, p);
  }
  return around;
}

}  // namespace

std::optional<TriangleSoup> facing_alike(const TriangleSoup& soup) {
  const std::vector<Triangle> triangles = merged_triangles(soup);
  Facing facing(triangles.size());
  if (!join_neighbours(sorted_half_edges(triangles), facing)) return std::nullopt;
  std::vector<double> area_ahead(triangles.size(), 0.0);  // of each root's, less what faces against it
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto at = [&](int i) { return soup.positions[soup.triangles[t][i]]; };
    const auto [root, against] = facing.root(static_cast<std::int32_t>(t));
    const double area = (at(1) - at(0)).cross(at(2) - at(0)).norm();
    area_ahead[root] += against ? -area : area;
  }
  TriangleSoup alike = soup;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [root, against] = facing.root(static_cast<std::int32_t>(t));
    if (against == (area_ahead[root] >= 0.0)) turn(alike.triangles[t]);
  }
  return alike;
}

TriangleSoup facing_outward(TriangleSoup soup) {
  int parts = 0;
  const std::vector<std::int32_t> part = parts_of(soup, parts);
  const Box box = bounding_box(soup);
  const std::vector<double> volumes = signed_volumes(soup, box.center(), part, parts);
  const bool one_sense = std::ranges::all_of(volumes, [](double v) { return v >= 0.0; }) ||
                         std::ranges::all_of(volumes, [](double v) { return v <= 0.0; });
  if (one_sense) return soup;
  const auto around = containers(soup, box, part, parts);
  const auto smaller = [&](std::int32_t a, std::int32_t b) {
    return std::abs(volumes[a]) < std::abs(volumes[b]);
  };
  std::vector<std::int32_t> largest_first(parts);
  std::iota(largest_first.begin(), largest_first.end(), 0);
  std::ranges::stable_sort(largest_first, [&](std::int32_t a, std::int32_t b) { return smaller(b, a); });
  std::vector<std::uint8_t> turned(parts, 0);
  for (const std::int32_t p : largest_first) {
    const auto next = std::ranges::min_element(around[p], smaller);
    turned[p] = next != around[p].end() ? turned[*next] : static_cast<std::uint8_t>(volumes[p] < 0.0);
  }
  for (std::size_t t = 0; t < part.size(); ++t)
    if (turned[part[t]] != 0) turn(soup.triangles[t]);
  return soup;
}

double signed_volume(const TriangleSoup& soup) {
  const Vec3 center = bounding_box(soup).center();  // where cancellation is least
  double volume = 0.0;
  for (const Triangle& t : soup.triangles) volume += volume_to(soup, t, center);
  return volume;
}

}  // namespace isochor
