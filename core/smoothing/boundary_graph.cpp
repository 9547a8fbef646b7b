#include "core/smoothing/boundary_graph.h"

#include <algorithm>

#include "core/parallel/cancellable_range.h"

namespace isochor {
namespace {

bool is_axis_aligned(const std::array<std::int32_t, 3>& a, const std::array<std::int32_t, 3>& b) {
  return (a[0] != b[0]) + (a[1] != b[1]) + (a[2] != b[2]) == 1;
}

void collect_vertices(const TetMesh& mesh, BoundaryGraph& graph) {
  graph.index.assign(mesh.positions.size(), -1);
  for (const Triangle& triangle : cancellable(mesh.surface))
    for (const std::int32_t v : triangle) graph.index[v] = 0;
  for (std::size_t v = 0; v < graph.index.size(); ++v) {
    if (graph.index[v] < 0) continue;
    graph.index[v] = static_cast<std::int32_t>(graph.vertices.size());
    graph.vertices.push_back(static_cast<std::int32_t>(v));
  }
}

/// Calls visit(a, b) for each directed edge of the surface's triangles. The surface is closed, so that every
/// edge comes in both directions.
template <class Visit>
void for_edges(const TetMesh& mesh, UmbrellaEdges edges, Visit&& visit) {
  for (const Triangle& t : cancellable(mesh.surface))
    for (int e = 0; e < 3; ++e) {
      const std::int32_t a = t[e], b = t[(e + 1) % 3];
      if (edges == UmbrellaEdges::all || is_axis_aligned(mesh.nodes[a], mesh.nodes[b])) visit(a, b);
    }
}

// An edge that four boundary faces share (a hinge) was collected twice.
void remove_duplicates(BoundaryGraph& graph) {
  std::int32_t end = 0;
  for (std::size_t v = 0; v < graph.vertices.size(); ++v) {
    if (v % 4096 == 0) throw_if_scope_cancelled();
    const auto begin = graph.neighbors.begin() + graph.first[v];
    const auto stop = graph.neighbors.begin() + graph.first[v + 1];
    std::sort(begin, stop);
    graph.first[v] = end;
    end = static_cast<std::int32_t>(std::unique_copy(begin, stop, graph.neighbors.begin() + end) -
                                    graph.neighbors.begin());
  }
  graph.first.back() = end;
  graph.neighbors.resize(end);
}

}  // namespace

BoundaryGraph make_boundary_graph(const TetMesh& mesh, UmbrellaEdges edges) {
  BoundaryGraph graph;
  collect_vertices(mesh, graph);
  graph.first.assign(graph.vertices.size() + 1, 0);
  for_edges(mesh, edges, [&](std::int32_t a, std::int32_t) { ++graph.first[graph.index[a] + 1]; });
  for (std::size_t v = 0; v < graph.vertices.size(); ++v) graph.first[v + 1] += graph.first[v];
  graph.neighbors.resize(graph.first.back());
  std::vector<std::int32_t> next(graph.first.begin(), graph.first.end() - 1);
  for_edges(mesh, edges, [&](std::int32_t a, std::int32_t b) {
    graph.neighbors[next[graph.index[a]]++] = graph.index[b];
  });
  remove_duplicates(graph);
  return graph;
}

}  // namespace isochor
