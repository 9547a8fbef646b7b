#include "core/smoothing/local_volume.h"

#include <algorithm>

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// Corners around the face of two triangles that follow one another in the surface.
std::array<std::int32_t, 4> face_of(const Triangle& first, const Triangle& second) {
  const auto missing = [](const Triangle& from, const Triangle& in) {
    return std::ranges::find_if(from, [&](std::int32_t v) { return std::ranges::count(in, v) == 0; }) -
           from.begin();
  };
  const auto apex = missing(first, second);
  return {first[apex], first[(apex + 1) % 3], second[missing(second, first)], first[(apex + 2) % 3]};
}

}  // namespace

LocalVolume::LocalVolume(const TetMesh& mesh, const BoundaryGraph& graph) : graph_(graph) {
  faces_.reserve(mesh.surface.size() / 2);
  for (std::size_t t = 0; t + 1 < mesh.surface.size(); t += 2) {
    auto& face = faces_.emplace_back(face_of(mesh.surface[t], mesh.surface[t + 1]));
    for (std::int32_t& v : face) v = graph.index[v];
  }
  normals_.resize(graph.vertices.size()), areas_.resize(normals_.size()), taken_.resize(normals_.size());
}

void LocalVolume::update_normals(const std::vector<Vec3>& x) {
  std::ranges::fill(normals_, Vec3::Zero());
  std::ranges::fill(areas_, 0.0);
  for (const auto& f : faces_) {
    const Vec3 quarter = 0.125 * (x[f[2]] - x[f[0]]).cross(x[f[3]] - x[f[1]]);
    const double area = quarter.norm();
    for (const std::int32_t v : f) normals_[v] += quarter, areas_[v] += area;
  }
}

void LocalVolume::balance(const std::vector<Vec3>& positions, std::vector<Vec3>& moves) {
  update_normals(positions);
  const auto count = static_cast<std::int64_t>(moves.size());
  for (std::int64_t v = 0; v < count; ++v)
    taken_[v] = -normals_[v].dot(moves[v]) / (1.0 + static_cast<double>(graph_.neighbors_of(v).size()));
  parallel_for(count, 2048, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = begin; v < end; ++v) {
      double volume = taken_[v];
      for (const std::int32_t n : graph_.neighbors_of(v)) volume += taken_[n];
      // The normals of a cusp cancel: it takes less than the whole.
      const double most = std::max(normals_[v].squaredNorm(), 0.25 * areas_[v] * areas_[v]);
      moves[v] += volume / most * normals_[v];
    }
  });
}

}  // namespace isochor
