#include "core/smoothing/rescale.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/common/compensated_sum.h"
#include "core/parallel/cancellable_range.h"

namespace isochor {
namespace {

std::int32_t find_root(std::vector<std::int32_t>& parent, std::int32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

/// Volume and first moment, relative to an origin near the mesh so that nothing cancels.
struct Moments {
  std::vector<double> volume;
  std::vector<Vec3> first;
};

Moments moments(const TetMesh& mesh, const VertexComponents& components, const Vec3& origin) {
  Moments m{{}, std::vector<Vec3>(components.count, Vec3::Zero())};
  std::vector<CompensatedSum> volumes(components.count);
  const auto& x = mesh.positions;
  for (const Tet& t : cancellable(mesh.tets)) {
    const std::int32_t c = components.of_vertex[t[0]];
    const double volume = tet_volume(x[t[0]], x[t[1]], x[t[2]], x[t[3]]);
    volumes[c].add(volume);
    m.first[c] += volume * (0.25 * (x[t[0]] + x[t[1]] + x[t[2]] + x[t[3]]) - origin);
  }
  for (const CompensatedSum& volume : volumes) m.volume.push_back(volume.value());
  return m;
}

}  // namespace

VertexComponents vertex_components(const TetMesh& mesh) {
  std::vector<std::int32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Cell& cell : cancellable(mesh.cells)) {
    const std::int32_t root = find_root(parent, cell.corners[0]);
    for (const std::int32_t v : cell.corners) parent[find_root(parent, v)] = root;
  }
  VertexComponents components;
  std::vector<std::int32_t> label(parent.size(), -1);
  components.of_vertex.resize(parent.size());
  for (std::size_t v = 0; v < parent.size(); ++v) {
    if (v % 4096 == 0) throw_if_scope_cancelled();
    const std::int32_t root = find_root(parent, static_cast<std::int32_t>(v));
    if (label[root] < 0) label[root] = components.count++;
    components.of_vertex[v] = label[root];
  }
  return components;
}

std::vector<double> component_volumes(const TetMesh& mesh, const VertexComponents& components) {
  return moments(mesh, components, mesh.grid.origin).volume;
}

void rescale(const VertexComponents& components, const std::vector<double>& volumes, TetMesh& mesh) {
  constexpr int passes = 3;  // the second already meets round-off; far from the origin a third may help
  for (int pass = 0; pass < passes; ++pass) {
    const Moments m = moments(mesh, components, mesh.grid.origin);
    double error = 0.0;
    for (int c = 0; c < components.count; ++c)
      error = std::max(error, std::abs(m.volume[c] / volumes[c] - 1.0));
    if (error < 1e-14) return;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const std::int32_t c = components.of_vertex[v];
      const Vec3 centroid = mesh.grid.origin + m.first[c] / m.volume[c];
      mesh.positions[v] = centroid + std::cbrt(volumes[c] / m.volume[c]) * (mesh.positions[v] - centroid);
    }
  }
}

}  // namespace isochor
