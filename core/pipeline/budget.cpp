#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "core/pipeline/pipeline.h"

namespace isochor {
namespace {

// Least squares of the largest resident sets of 21 runs, from 12 to 980 MiB: cubes, scans, soups and loose
// triangles at 32 to 384 voxels and 8 to 144 cells, none of them off by more than 17 %; an eighth is added to
// that.
constexpr double process_bytes = 14e6;
constexpr double bytes_a_voxel = 8.5;   // distance 4, votes and inside 2, bit planes 2
constexpr double bytes_a_cell = 475.0;  // both meshes, the smoother's and the locator's lists
constexpr double bytes_a_triangle = 405.0, bytes_a_vertex = 265.0;  // soup, its trees and the embedding
constexpr double seconds_a_voxel = 4e-8, seconds_a_cell = 1e-6, seconds_a_triangle = 3e-6;

/// Cells of a solid and, where that is more, of a layer along its surface as thick as both sides of P_in.
/// Either grows by what a density under a half adds on each side.
std::int64_t expected_cells(const SoupSize& soup, const MeshingOptions& options, double d_in) {
  const double cell = soup.box.size().maxCoeff() / options.lattice.cells, density = options.lattice.density;
  const double added = (0.5 - density) * cell, layer = 2.0 * d_in;
  const double solid = soup.volume + soup.area * added;
  const double sheet = layer > density * cell ? soup.area * (layer + 2.0 * added) : 0.0;
  return std::llround(std::max({1.0, solid / std::pow(cell, 3), sheet / std::pow(cell, 3)}));
}

constexpr double least_p_in_voxels = 0.87;  // √3/2: half a step of a diagonal ray

template <class Fits>
int largest_fitting(int from, int step, int least, Fits&& fits) {
  int value = from;
  while (value > least && !fits(value)) value -= step;
  return std::max(value, least);
}

}  // namespace

Estimate estimate(const SoupSize& soup, const MeshingOptions& options) {
  Estimate e;
  const Box& box = soup.box;
  const Grid voxels = distance_grid(box, {options.voxels, field_padding});
  const double d_in = options.pseudo_volume.p_in_voxels * voxels.spacing;
  e.voxels = voxels.count();
  e.max_cells = lattice_grid(box, options.lattice.cells, d_in).count();
  e.max_tets = 5 * e.max_cells;
  e.cells = std::min(e.max_cells, expected_cells(soup, options, d_in));
  e.bytes = std::llround(process_bytes + bytes_a_voxel * static_cast<double>(e.voxels) +
                         bytes_a_cell * static_cast<double>(e.cells) +
                         bytes_a_triangle * static_cast<double>(soup.triangles) +
                         bytes_a_vertex * static_cast<double>(soup.vertices));
  e.seconds = seconds_a_voxel * static_cast<double>(e.voxels) +
              seconds_a_cell * static_cast<double>(e.cells) +
              seconds_a_triangle * static_cast<double>(soup.triangles);
  return e;
}

void check_budget(const SoupSize& soup, const MeshingOptions& options, std::int64_t max_bytes) {
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

MeshingOptions preview_options(const MeshingOptions& options, int most_cells) {
  MeshingOptions preview = options;
  preview.voxels = std::min(options.voxels, 2 * most_cells);
  const double scale = static_cast<double>(preview.voxels) / options.voxels;
  PseudoVolumeOptions& thresholds = preview.pseudo_volume;
  thresholds.p_in_voxels = std::max(least_p_in_voxels, scale * thresholds.p_in_voxels);
  thresholds.p_subs_voxels = std::max(thresholds.p_in_voxels, scale * thresholds.p_subs_voxels);
  preview.lattice.cells = std::min(options.lattice.cells, preview.voxels / 2);
  return preview;
}

int preview_stride(const MeshingOptions& options, int most_cells, bool encloses) {
  const PseudoVolumeOptions& thresholds = options.pseudo_volume;
  if (thresholds.p_in || thresholds.p_subs) return 1;
  const int of_voxels = options.voxels / (2 * std::max(most_cells, options.lattice.cells)),
            of_thresholds = static_cast<int>(thresholds.p_in_voxels / least_p_in_voxels);
  return std::max(1, encloses ? of_voxels : std::min(of_voxels, of_thresholds));
}

MeshingOptions thinned(const MeshingOptions& options, int stride) {
  MeshingOptions thin = options;
  thin.voxels /= stride;
  PseudoVolumeOptions& thresholds = thin.pseudo_volume;
  thresholds.p_in_voxels = std::max(least_p_in_voxels, thresholds.p_in_voxels / stride);
  thresholds.p_subs_voxels = std::max(thresholds.p_in_voxels, thresholds.p_subs_voxels / stride);
  return thin;
}

}  // namespace isochor
