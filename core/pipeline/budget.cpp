#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "core/pipeline/pipeline.h"

namespace isochor {
namespace {

// Fitted to the largest resident sets of cubes of 14,000 to 880,000 cells, scans at 128 to 384 voxels and a
// torus of 800,000 triangles.
constexpr std::int64_t bytes_a_voxel = 9;   // distance 4, votes and inside 2, bit planes 2, scratch
constexpr std::int64_t bytes_a_cell = 480;  // a kept one: both meshes, the smoother's and the locator's lists
constexpr std::int64_t bytes_a_triangle = 500;  // soup, its trees and the embedding
constexpr double seconds_a_voxel = 4e-8, seconds_a_cell = 1e-6, seconds_a_triangle = 3e-6;

template <class Fits>
int largest_fitting(int from, int step, int least, Fits&& fits) {
  int value = from;
  while (value > least && !fits(value)) value -= step;
  return std::max(value, least);
}

}  // namespace

Estimate estimate(const TriangleSoup& soup, const MeshingOptions& options) {
  Estimate e;
  const Box box = bounding_box(soup);
  const Grid voxels = distance_grid(box, {options.voxels, required_padding(options.pseudo_volume)});
  const double d_in = options.pseudo_volume.p_in_voxels * voxels.spacing;
  e.voxels = voxels.count();
  e.max_cells = lattice_grid(box, options.lattice.cells, d_in).count();
  e.max_tets = 5 * e.max_cells;
  const auto triangles = static_cast<std::int64_t>(soup.triangles.size());
  e.bytes = e.voxels * bytes_a_voxel + e.max_cells * bytes_a_cell + triangles * bytes_a_triangle;
  e.seconds = seconds_a_voxel * static_cast<double>(e.voxels) +
              seconds_a_cell * static_cast<double>(e.max_cells) +
              seconds_a_triangle * static_cast<double>(triangles);
  return e;
}

void check_budget(const TriangleSoup& soup, const MeshingOptions& options, std::int64_t max_bytes) {
  const Estimate needed = estimate(soup, options);
  if (needed.bytes <= max_bytes) return;
  const auto fits = [&](int voxels, int cells) {
    MeshingOptions smaller = options;
    smaller.voxels = voxels, smaller.lattice.cells = std::min(cells, voxels / 2);
    return estimate(soup, smaller).bytes <= max_bytes;
  };
  constexpr double mebibyte = 1024.0 * 1024.0;
  const auto mib = [&](std::int64_t bytes) {
    return std::to_string(std::llround(static_cast<double>(bytes) / mebibyte)) + " MiB";
  };
  const std::string what = std::to_string(options.voxels) + " voxels and " +
                           std::to_string(options.lattice.cells) + " cells may need " + mib(needed.bytes) +
                           ", but " + mib(max_bytes) + " are allowed";
  const int cells =
      largest_fitting(options.lattice.cells, 2, 2, [&](int c) { return fits(options.voxels, c); });
  if (fits(options.voxels, cells))
    throw Error(ErrorCode::over_budget, what,
                "the largest setting that fits is cells " + std::to_string(cells),
                {{"/cells", "too many for the memory allowed", 2.0, static_cast<double>(cells)}});
  const int voxels =
      largest_fitting(options.voxels, 1, 16, [&](int v) { return fits(v, options.lattice.cells); });
  throw Error(ErrorCode::over_budget, what,
              "the largest setting that fits is voxels " + std::to_string(voxels),
              {{"/voxels", "too many for the memory allowed", 16.0, static_cast<double>(voxels)}});
}

std::int64_t memory_budget() {
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) / 4 * 3 * sysconf(_SC_PAGESIZE);
}

MeshingOptions preview_options(const MeshingOptions& options) {
  MeshingOptions preview = options;
  preview.voxels = std::max(16, options.voxels / 2);
  const double scale = static_cast<double>(preview.voxels) / options.voxels;
  PseudoVolumeOptions& thresholds = preview.pseudo_volume;
  thresholds.p_in_voxels = std::max(0.87, scale * thresholds.p_in_voxels);
  thresholds.p_subs_voxels = std::max(thresholds.p_in_voxels, scale * thresholds.p_subs_voxels);
  preview.lattice.cells = std::min(options.lattice.cells, preview.voxels / 2);
  return preview;
}

}  // namespace isochor
