#include "core/mesh_input/inspect.h"

#include <algorithm>
#include <numeric>

#include "core/mesh_input/orientation.h"
#include "core/mesh_input/self_intersections.h"
#include "core/mesh_input/topology.h"
#include "core/parallel/cancellable_sort.h"

namespace isochor {
namespace {

constexpr std::size_t max_defect_locations = 64;

class DefectCounter {
 public:
  explicit DefectCounter(std::string_view name) : defect_{name, 0, {}} {}
  void add(const Vec3& location) {
    ++defect_.count;
    if (defect_.locations.size() < max_defect_locations) defect_.locations.push_back(location);
  }
  void move_into(std::vector<Defect>& defects) {
    if (defect_.count > 0) defects.push_back(std::move(defect_));
  }
  std::int64_t count() const { return defect_.count; }

 private:
  Defect defect_;
};

class Inspector {
 public:
  explicit Inspector(const TriangleSoup& soup) : soup_(soup), merged_(merge_vertices(soup)) {}

  MeshReport run() {
    report_.vertices = static_cast<std::int64_t>(soup_.positions.size());
    report_.triangles = static_cast<std::int64_t>(soup_.triangles.size());
    report_.bounds = bounding_box(soup_);
    measure();
    count_vertices();
    throw_if_scope_cancelled();
    const std::vector<Triangle> proper = proper_triangles();
    throw_if_scope_cancelled();
    const std::vector<Triangle> repeated = count_duplicates(proper);
    throw_if_scope_cancelled();
    count_edges(proper, repeated);
    throw_if_scope_cancelled();
    count_self_intersections(proper);
    throw_if_scope_cancelled();
    report_.components = count_components(proper);
    return std::move(report_);
  }

 private:
  const Vec3& corner(std::size_t triangle, int i) const {
    return soup_.positions[soup_.triangles[triangle][i]];
  }
  Vec3 centroid(const Triangle& t) const {
    return (soup_.positions[t[0]] + soup_.positions[t[1]] + soup_.positions[t[2]]) / 3.0;
  }

  void measure() {
    report_.volume = signed_volume(soup_);
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t) {
      const Vec3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
      report_.area += 0.5 * (b - a).cross(c - a).norm();
    }
  }

  void count_vertices() {
    std::vector<char> used(soup_.positions.size(), 0);
    for (const Triangle& triangle : soup_.triangles)
      for (std::int32_t v : triangle) used[v] = 1;
    DefectCounter unused("unused_vertices"), duplicate("duplicate_vertices");
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (used[v] == 0) unused.add(soup_.positions[v]);
      if (merged_[v] != static_cast<std::int32_t>(v)) duplicate.add(soup_.positions[v]);
    }
    unused.move_into(report_.defects);
    duplicate.move_into(report_.defects);
  }

  /// Triangles over merged vertices that have three of them. One of no area but three corners fills the gap
  /// at a T-junction: without its edges a closed surface would look open.
  std::vector<Triangle> proper_triangles() {
    DefectCounter degenerate("degenerate_triangles");
    std::vector<Triangle> proper;
    proper.reserve(soup_.triangles.size());
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t) {
      const Triangle& original = soup_.triangles[t];
      const Triangle triangle{merged_[original[0]], merged_[original[1]], merged_[original[2]]};
      if (is_degenerate(triangle)) degenerate.add(centroid(original));
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        proper.push_back(triangle);
    }
    degenerate.move_into(report_.defects);
    return proper;
  }

  bool is_degenerate(const Triangle& t) const {
    const Vec3 &a = soup_.positions[t[0]], &b = soup_.positions[t[1]], &c = soup_.positions[t[2]];
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    return !((b - a).cross(c - a).norm() > 1e-12 * longest);
  }

  /// Returns them, their corners sorted.
  std::vector<Triangle> count_duplicates(const std::vector<Triangle>& proper) {
    std::vector<Triangle> sorted = proper;
    for (Triangle& triangle : sorted) std::sort(triangle.begin(), triangle.end());
    cancellable_sort(sorted);
    DefectCounter duplicate("duplicate_triangles");
    std::vector<Triangle> repeated;
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (sorted[i] == sorted[i - 1]) {
        duplicate.add(centroid(sorted[i]));
        repeated.push_back(sorted[i]);
      }
    duplicate.move_into(report_.defects);
    return repeated;
  }

  /// The outer edges of leaves of two equal triangles are among those of `repeated`, and have no others.
  void count_edges(const std::vector<Triangle>& proper, const std::vector<Triangle>& repeated) {
    std::vector<std::array<std::int32_t, 2>> repeated_edges;
    for (const auto& [a, b, c] : repeated)
      repeated_edges.insert(repeated_edges.end(), {{a, b}, {b, c}, {a, c}});
    cancellable_sort(repeated_edges);
    bool balanced = !proper.empty();
    DefectCounter open("open_edges"), non_manifold("non_manifold_edges"), inconsistent("inconsistent_edges");
    for_each_edge(proper, [&](const EdgeUse& edge) {
      const Vec3 middle = 0.5 * (soup_.positions[edge.low] + soup_.positions[edge.high]);
      const int uses = edge.forward + edge.backward;
      if (uses == 1) open.add(middle);
      if (uses > 2) non_manifold.add(middle);
      if (uses == 2 && edge.forward != edge.backward) inconsistent.add(middle);
      const bool outer =
          uses == 2 && std::ranges::binary_search(repeated_edges, std::array{edge.low, edge.high});
      balanced = balanced && edge.forward == edge.backward && !outer;
    });
    report_.winds = balanced;
    report_.closed = !proper.empty() && open.count() + non_manifold.count() + inconsistent.count() == 0;
    open.move_into(report_.defects);
    non_manifold.move_into(report_.defects);
    inconsistent.move_into(report_.defects);
  }

  void count_self_intersections(const std::vector<Triangle>& proper) {
    SelfIntersections found = find_self_intersections(soup_.positions, proper, max_defect_locations);
    const std::string_view name = found.complete ? "self_intersections" : "self_intersections_at_least";
    if (found.pairs > 0) report_.defects.push_back({name, found.pairs, std::move(found.locations)});
  }

  std::int64_t count_components(const std::vector<Triangle>& proper) const {
    std::vector<std::int32_t> parent(soup_.positions.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t v) {
      while (parent[v] != v) v = parent[v] = parent[parent[v]];
      return v;
    };
    std::vector<char> used(parent.size(), 0);
    for (const Triangle& triangle : proper)
      for (std::int32_t v : triangle) parent[root(v)] = root(triangle[0]), used[v] = 1;
    std::int64_t components = 0;
    for (std::size_t v = 0; v < parent.size(); ++v)
      components += used[v] != 0 && parent[v] == static_cast<std::int32_t>(v) ? 1 : 0;
    return components;
  }

  const TriangleSoup& soup_;
  std::vector<std::int32_t> merged_;
  MeshReport report_;
};

}  // namespace

bool has(const MeshReport& report, std::string_view defect) {
  return std::ranges::any_of(report.defects, [&](const Defect& d) { return d.name.starts_with(defect); });
}

MeshReport inspect(const TriangleSoup& soup) {
  return Inspector(soup).run();
}

}  // namespace isochor
