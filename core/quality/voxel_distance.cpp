#include "core/quality/voxel_distance.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// From a coordinate to the voxel of that number, in voxels.
double gap(double at, int voxel) {
  return std::max({voxel - at, at - (voxel + 1), 0.0});
}

double squared(double x) {
  return x * x;
}

/// A range of voxels along an axis.
struct Reach {
  int first, last;
  Reach(double at, double reach, int size)
      : first(std::max(0, static_cast<int>(std::floor(at - reach)))),
        last(std::min(size - 1, static_cast<int>(std::floor(at + reach)))) {}
};

/// Squared, in voxels, from `at` to the nearest voxel that is not `own`, where it is within `reach`.
double search(const PseudoVolume& volume, const Vec3& at, std::uint8_t own, double reach) {
  const Grid& grid = volume.grid;
  const Reach x(at.x(), reach, grid.size.x()), y(at.y(), reach, grid.size.y()),
      z(at.z(), reach, grid.size.z());
  double best = squared(reach);
  for (int k = z.first; k <= z.last; ++k)
    for (int j = y.first; j <= y.last; ++j) {
      const double beside = squared(gap(at.y(), j)) + squared(gap(at.z(), k));
      if (beside >= best) continue;
      const std::uint8_t* row = volume.inside.data() + grid.index(0, j, k);
      for (int i = x.first; i <= x.last; ++i)
        if (row[i] != own) best = std::min(best, beside + squared(gap(at.x(), i)));
    }
  return best;
}

}  // namespace

double distance_to_surface(const PseudoVolume& volume, const Vec3& p) {
  const Grid& grid = volume.grid;
  const Vec3 at = (p - grid.origin) / grid.spacing;
  const Vec3i voxel = at.array().floor().cast<int>();
  const std::uint8_t own = grid.contains(voxel.x(), voxel.y(), voxel.z())
                               ? volume.inside[grid.index(voxel.x(), voxel.y(), voxel.z())]
                               : std::uint8_t{0};
  const double all = grid.size.cast<double>().norm() + (at - 0.5 * grid.size.cast<double>()).norm();
  for (double reach = 2.0;; reach *= 2.0) {  // most find it at once
    if (const double found = search(volume, at, own, reach); found < squared(reach))
      return grid.spacing * std::sqrt(found);
    if (reach > all) return 1e300;
  }
}

std::vector<std::int32_t> boundary_vertices(const TetMesh& mesh) {
  std::vector<std::uint8_t> on_boundary(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.surface)
    for (const std::int32_t v : t) on_boundary[v] = 1;
  std::vector<std::int32_t> vertices;
  for (std::size_t v = 0; v < on_boundary.size(); ++v)
    if (on_boundary[v] != 0) vertices.push_back(static_cast<std::int32_t>(v));
  return vertices;
}

VoxelDistance voxel_distance(const TetMesh& mesh, const PseudoVolume& volume, const Progress& progress) {
  constexpr std::int64_t grain = 256;  // summed in chunks that no thread count changes
  const std::vector<std::int32_t> vertices = boundary_vertices(mesh);
  const auto count = static_cast<std::int64_t>(vertices.size());
  struct Part {
    double largest = 0.0, sum = 0.0;
  };
  std::vector<Part> parts((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    Part& part = parts[begin / grain];
    for (auto n = begin; n < end; ++n) {
      const double distance = distance_to_surface(volume, mesh.positions[vertices[n]]);
      part.largest = std::max(part.largest, distance);
      part.sum += distance;
    }
  });
  Part all;
  for (const Part& part : parts) all.largest = std::max(all.largest, part.largest), all.sum += part.sum;
  const double diagonal = std::sqrt(3.0) * mesh.grid.spacing;
  return {all.largest / diagonal,
          all.sum / (diagonal * static_cast<double>(std::max<std::int64_t>(count, 1)))};
}

}  // namespace isochor
