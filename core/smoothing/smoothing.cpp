#include "core/smoothing/smoothing.h"

#include <algorithm>
#include <numeric>

#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"
#include "core/smoothing/boundary_graph.h"
#include "core/smoothing/limiter.h"
#include "core/smoothing/local_volume.h"
#include "core/smoothing/rescale.h"

namespace isochor {
namespace {

/// A lone cell keeps its shape however much it shrinks and grows back; only larger components tell of a loss.
constexpr double notable_share = 0.01;

void refuse_outside(const char* name, double value, double min, double max) {
  if (value >= min && value <= max) return;
  throw Error(ErrorCode::invalid_argument, std::string(name) + " is out of range", "see the allowed range",
              {{"/" + std::string(name), "out of range", min, max}});
}

void check(const SmoothingOptions& options) {
  refuse_outside("smoothing_iterations", options.iterations, 0, 20);
  refuse_outside("smoothing_mu", options.mu, 0.0, 0.4);
  refuse_outside("min_dihedral_deg", options.min_dihedral_deg, 0.0, 54.0);
}

/// The default iterations hardly need the floor: where they do, they keep half as much again, up to 29°, and
/// leave the rest to further ones.
double floor_of(int iteration, double floor) {
  constexpr double early = 29.0;
  return iteration < SmoothingOptions{}.iterations ? std::max(floor, std::min(1.5 * floor, early)) : floor;
}

/// U(x_i) = mean over the neighbours of x_j − x_i.
void umbrella(const BoundaryGraph& graph, const std::vector<Vec3>& x, std::vector<Vec3>& u) {
  parallel_for(static_cast<std::int64_t>(x.size()), 2048, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = begin; v < end; ++v) {
      Vec3 sum = Vec3::Zero();
      const auto neighbors = graph.neighbors_of(v);
      for (const std::int32_t n : neighbors) sum += x[n] - x[v];
      u[v] = sum / static_cast<double>(std::max<std::size_t>(1, neighbors.size()));
    }
  });
}

TetMesh copy_of(const TetMesh& mesh) {
  return {cancellable_copy(mesh.positions),
          cancellable_copy(mesh.tets),
          cancellable_copy(mesh.cells),
          cancellable_copy(mesh.nodes),
          mesh.grid,
          cancellable_copy(mesh.surface)};
}

}  // namespace

Smoothed smooth(const TetMesh& mesh, const SmoothingOptions& options, Progress& progress) {
  check(options);
  const CancelScope scope(progress);
  Smoothed result{copy_of(mesh), 0.0, 0};
  if (options.iterations == 0 || options.mu == 0.0) return result;

  const BoundaryGraph graph = make_boundary_graph(mesh, options.edges);
  progress.throw_if_cancelled();
  const VertexComponents components = vertex_components(mesh);
  progress.throw_if_cancelled();
  const std::vector<double> volumes = component_volumes(mesh, components);
  progress.throw_if_cancelled();
  MoveLimiter limiter(mesh, graph);
  progress.throw_if_cancelled();
  LocalVolume local_volume(mesh, graph);
  std::vector<Vec3> x(graph.vertices.size()), first(x.size()), second(x.size());
  for (int i = 0; i < options.iterations; ++i) {
    progress.report("smoothing", static_cast<double>(i) / options.iterations);
    for (std::size_t b = 0; b < x.size(); ++b) x[b] = result.mesh.positions[graph.vertices[b]];
    umbrella(graph, x, first);
    umbrella(graph, first, second);
    for (Vec3& u : second) u *= -options.mu;
    local_volume.balance(x, second);
    limiter.apply(second, floor_of(i, options.min_dihedral_deg), result.mesh.positions, progress);
  }
  result.limited_vertices = limiter.limited_vertices();
  const std::vector<double> shrunk = component_volumes(result.mesh, components);
  const double notable = notable_share * std::reduce(volumes.begin(), volumes.end());
  for (int c = 0; c < components.count; ++c)
    if (volumes[c] >= notable)
      result.largest_shrinkage = std::max(result.largest_shrinkage, 1.0 - shrunk[c] / volumes[c]);
  rescale(components, volumes, result.mesh);
  return result;
}

}  // namespace isochor
