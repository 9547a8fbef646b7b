#include "core/distance_field/distance_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>

#include "core/common/error.h"
#include "core/common/huge_vector.h"
#include "core/distance_field/block_kernel.h"
#include "core/distance_field/features.h"
#include "core/distance_field/fill.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

BlockTask make_task(const Features& features, DistanceField& field, const Progress& progress) {
  BlockTask task{};
  task.vertices = features.vertices.data();
  task.edges = features.edges.data();
  task.faces = features.faces.data();
  task.corners = features.corners.data();
  task.clusters = features.clusters.data();
  task.cluster_count = features.cluster_count();
  for (int axis = 0; axis < 3; ++axis) {
    task.box_min[axis] = features.box_min[axis].data();
    task.box_max[axis] = features.box_max[axis].data();
    task.size[axis] = field.grid.size[axis];
  }
  task.spacing = field.grid.spacing;
  task.distance = field.distance.data();
  task.owner = &progress;
  task.cancelled = [](const void* owner) { return static_cast<const Progress*>(owner)->cancelled(); };
  return task;
}

/// Memory aligned to a vector.
class Scratch {
 public:
  explicit Scratch(std::int64_t bytes)
      : memory_(::operator new (static_cast<std::size_t>(bytes), std::align_val_t{64})) {}
  ~Scratch() { ::operator delete (memory_, std::align_val_t{64}); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  void* get() const { return memory_; }

 private:
  void* memory_;
};

/// The roots [begin, end) of the grid's cubes, in the order x, y, z. Returns the largest distance.
float fill_roots(const BlockKernel& kernel, BlockTask task, std::int64_t begin, std::int64_t end) {
  const Scratch scratch(kernel.scratch_bytes(task.cluster_count));
  task.scratch = scratch.get();
  constexpr int edge = BlockKernel::root_edge;
  const std::int64_t nx = (task.size[0] + edge - 1) / edge, ny = (task.size[1] + edge - 1) / edge;
  float largest = 0.0F;
  for (std::int64_t root = begin; root < end; ++root) {
    const int corner[3] = {static_cast<int>(root % nx) * edge, static_cast<int>(root / nx % ny) * edge,
                           static_cast<int>(root / nx / ny) * edge};
    if (!kernel.fill(task, corner, largest)) throw Error(ErrorCode::cancelled, "cancelled");
  }
  return largest;
}

std::int64_t bytes_needed(const Grid& grid, std::int64_t triangles) {
  return grid.count() * static_cast<std::int64_t>(sizeof(float)) + features_bytes(triangles);
}

void check_budget(const TriangleSoup& soup, const Grid& grid, const DistanceFieldOptions& options) {
  const auto triangles = static_cast<std::int64_t>(soup.triangles.size());
  const std::int64_t bytes = bytes_needed(grid, triangles);
  if (bytes <= options.max_bytes) return;
  const Box box = bounding_box(soup);
  DistanceFieldOptions fitting = options;
  while (fitting.voxels >= least_voxels &&
         bytes_needed(grid_of_box(box, fitting), triangles) > options.max_bytes)
    --fitting.voxels;
  throw Error(ErrorCode::over_budget,
              fmt::format("the distance field would take {} MB, more than the limit of {} MB", bytes >> 20,
                          options.max_bytes >> 20),
              fitting.voxels >= least_voxels ? fmt::format("voxels up to {} fit", fitting.voxels)
                                             : "the mesh alone is too large: simplify it");
}

}  // namespace

void fill_distances(const TriangleSoup& soup, const BlockKernel& kernel, DistanceField& field,
                    Progress& progress) {
  const Features features = make_features(soup, field.grid);
  progress.throw_if_cancelled();
  const BlockTask task = make_task(features, field, progress);
  const Vec3i roots = (field.grid.size.array() + BlockKernel::root_edge - 1) / BlockKernel::root_edge;
  const std::int64_t count = std::int64_t{roots.x()} * roots.y() * roots.z();
  // Portions of a few milliseconds, so that progress can be told from this thread.
  constexpr std::int64_t portion = 32;
  std::vector<float> largest(static_cast<std::size_t>(count), 0.0F);
  for (std::int64_t first = 0; first < count; first += portion) {
    progress.report("distance_field", static_cast<double>(first) / static_cast<double>(count));
    parallel_for(std::min(portion, count - first), 4, [&](std::int64_t begin, std::int64_t end) {
      largest[first + begin] = fill_roots(kernel, task, first + begin, first + end);
    });
  }
  field.max_distance = *std::max_element(largest.begin(), largest.end());
  progress.report("distance_field", 1.0);
}

DistanceField make_distance_field(const TriangleSoup& soup, const DistanceFieldOptions& options,
                                  Progress& progress) {
  DistanceField field;
  field.grid = distance_grid(bounding_box(soup), options);
  field.padding = options.padding;
  check_budget(soup, field.grid, options);
  progress.throw_if_cancelled();
  field.distance.reserve(field.grid.count());
  prefer_huge_pages(field.distance.data(), field.distance.capacity() * sizeof(float));
  const CancelScope scope(progress);
  cancellable_resize(field.distance, static_cast<std::size_t>(field.grid.count()));
  fill_distances(soup, block_kernels().front(), field, progress);
  return field;
}

}  // namespace isochor
