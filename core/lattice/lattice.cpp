#include "core/lattice/lattice.h"

#include <algorithm>
#include <cmath>

#include "core/lattice/topology.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// Voxels of one axis whose centres lie in a cell, [begin, end) cut to the grid, and how many there would be
/// in an endless grid.
struct VoxelRange {
  int begin, end, uncut;
};

// Cells are closed: a centre on a cell's boundary counts for both sides, so that mirroring changes nothing.
std::vector<VoxelRange> voxel_ranges(const Grid& lattice, const Grid& voxels, int axis) {
  constexpr double round_off = 1e-6;
  std::vector<VoxelRange> ranges;
  const double step = lattice.spacing / voxels.spacing;
  const double start = (lattice.origin[axis] - voxels.origin[axis]) / voxels.spacing - 0.5;
  for (int c = 0; c < lattice.size[axis]; ++c) {
    const int begin = static_cast<int>(std::ceil(start + c * step - round_off));
    const int end = static_cast<int>(std::floor(start + (c + 1) * step + round_off)) + 1;
    ranges.push_back(
        {std::clamp(begin, 0, voxels.size[axis]), std::clamp(end, 0, voxels.size[axis]), end - begin});
  }
  return ranges;
}

// Sums along x, then y, then z touch each voxel once: as fast as a summed-volume table at the usual sizes,
// without its 4 bytes a voxel.
std::vector<float> densities(const PseudoVolume& volume, const Grid& lattice) {
  const auto xs = voxel_ranges(lattice, volume.grid, 0), ys = voxel_ranges(lattice, volume.grid, 1),
             zs = voxel_ranges(lattice, volume.grid, 2);
  std::vector<float> density(lattice.count());
  parallel_for(lattice.size.z(), 1, [&](std::int64_t first, std::int64_t last) {
    std::vector<std::int32_t> sums(static_cast<std::size_t>(lattice.size.x()) * lattice.size.y());
    for (auto ck = first; ck < last; ++ck) {
      std::ranges::fill(sums, 0);
      for (int k = zs[ck].begin; k < zs[ck].end; ++k)
        for (std::size_t cj = 0; cj < ys.size(); ++cj)
          for (int j = ys[cj].begin; j < ys[cj].end; ++j) {
            const std::uint8_t* row = volume.inside.data() + volume.grid.index(0, j, k);
            std::int32_t* sum = sums.data() + cj * xs.size();
            for (const VoxelRange& x : xs) {
              for (int i = x.begin; i < x.end; ++i) *sum += row[i];
              ++sum;
            }
          }
      float* out = density.data() + lattice.index(0, 0, static_cast<int>(ck));
      for (std::size_t c = 0; c < sums.size(); ++c) {
        const std::size_t ci = c % xs.size(), cj = c / xs.size();
        const double all = static_cast<double>(xs[ci].uncut) * ys[cj].uncut * zs[ck].uncut;
        out[c] = static_cast<float>(sums[c] / all);
      }
    }
  });
  return density;
}

void check(const PseudoVolume& volume, const Box& box, const LatticeOptions& options) {
  const double voxels = std::round(box.size().maxCoeff() / volume.grid.spacing);
  const double most = std::min(256.0, std::floor(voxels / 2.0));
  if (options.cells < 2 || options.cells > most)
    throw Error(ErrorCode::invalid_argument,
                "cells is " + std::to_string(options.cells) + ", but must be between 2 and half the voxels",
                "use at most " + std::to_string(static_cast<int>(most)) + " cells, or more voxels",
                {{"/cells", "out of range", 2.0, most}});
  if (!(options.density >= 0.0 && options.density <= 1.0))
    throw Error(ErrorCode::invalid_argument, "density must be between 0 and 1",
                "use 0.5, or 0.2 for thin parts", {{"/density", "out of range", 0.0, 1.0}});
}

/// An even number that covers the extent, at least two.
int even_cells(double extent, double cell) {
  return 2 * std::max(1, static_cast<int>(std::ceil(extent / (2.0 * cell) - 1e-9)));
}

/// Calls visit(cell, i, j, k) for every cell of the grid.
template <class Visit>
void for_cells(const Grid& grid, Visit&& visit) {
  std::int64_t cell = 0;
  for (int k = 0; k < grid.size.z(); ++k)
    for (int j = 0; j < grid.size.y(); ++j)
      for (int i = 0; i < grid.size.x(); ++i) visit(cell++, i, j, k);
}

bool touches_kept(const Lattice& lattice, int i, int j, int k) {
  const Vec3i low = (Vec3i(i, j, k).array() - 1).max(0),
              high = (Vec3i(i, j, k).array() + 1).min(lattice.grid.size.array() - 1);
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (lattice.kept[lattice.grid.index(x, y, z)] != 0) return true;
  return false;
}

/// What a density calls for: all of it at a threshold of a half; others count the cells on the boundary for
/// more or less, as keeping them does.
double wanted_density(double density, double threshold) {
  return density > 0.0 && density < 1.0 ? std::clamp(density + 0.5 - threshold, 0.0, 1.0) : density;
}

/// Volume in cells that the densities call for.
double wanted_volume(const Lattice& lattice, double threshold) {
  double volume = 0.0;
  for_cells(lattice.grid, [&](std::int64_t cell, int i, int j, int k) {
    if (lattice.density[cell] > 0.0F && (lattice.kept[cell] != 0 || touches_kept(lattice, i, j, k)))
      volume += wanted_density(lattice.density[cell], threshold);
  });
  return volume;
}

/// The sides of the kept cells, seen from a centre. In cells.
struct Sides {
  double outward = 0.0;          ///< distance along their axis, on average, signed by where they face
  double any_way = 0.0;          ///< that without a sign
  Vec3 farthest = Vec3::Zero();  ///< distance of those that face along an axis
  Vec3 missing = Vec3::Zero();   ///< volume by which those along an axis should lie farther out
  Vec3 share = Vec3::Zero();     ///< of them that face along an axis
};

Sides sides_about(const Vec3& centre, const Lattice& lattice, double threshold) {
  const Vec3i& size = lattice.grid.size;
  Sides sum;
  for_cells(lattice.grid, [&](std::int64_t cell, int i, int j, int k) {
    if (lattice.kept[cell] == 0) return;
    const Vec3i at(i, j, k);
    const double here = wanted_density(lattice.density[cell], threshold);
    std::int64_t stride = 1;
    for (int axis = 0; axis < 3; stride *= size[axis++])
      for (const int side : {0, 1}) {
        const bool last = at[axis] == (side == 0 ? 0 : size[axis] - 1);
        const std::int64_t next = cell + (side == 0 ? -stride : stride);
        if (!last && lattice.kept[next] != 0) continue;
        const double distance = at[axis] + side - centre[axis];
        sum.outward += side == 0 ? -distance : distance;
        sum.any_way += std::abs(distance);
        sum.farthest[axis] = std::max(sum.farthest[axis], std::abs(distance));
        sum.missing[axis] += (last ? 0.0 : wanted_density(lattice.density[next], threshold)) - (1.0 - here);
        sum.share[axis] += 1.0;
      }
  });
  const double sides = sum.share.sum();
  sum.outward /= sides, sum.any_way /= sides, sum.share /= sides;
  return sum;
}

// A flat side is kept or dropped as a whole layer, so that a box is off by up to half a cell a side whatever
// the resolution. Scaling all of the lattice about the centroid of its cells corrects the volume and keeps
// every angle, but moves the ends of a rod by more than what its sides miss. So none moves by more than half
// a cell, and what then lacks is made up for along the axes whose sides miss it, by as much again. Where few
// cells are full, parts are thinner than cells, and the volume is no matter of rounding. The two sides of a
// wall move the same way, and a shell would leave its place for a little volume: it is not stretched.
void fit_volume(double threshold, double true_volume, Lattice& lattice) {
  constexpr double tolerance = 0.02, solid = 1.0 / 3.0, half_a_cell = 0.5, rounding = 0.15;
  Vec3 sum = Vec3::Zero();
  std::int64_t full = 0;
  for_cells(lattice.grid, [&](std::int64_t cell, int i, int j, int k) {
    if (lattice.kept[cell] == 0) return;
    sum += Vec3(i + 0.5, j + 0.5, k + 0.5);
    full += lattice.density[cell] >= 1.0F;
  });
  const auto kept = static_cast<double>(lattice.kept_count);
  if (static_cast<double>(full) < solid * kept) return;
  const Vec3 centre = sum / kept;
  const double counted = wanted_volume(lattice, 0.5), off = true_volume / counted;
  double wanted = wanted_volume(lattice, threshold);
  const bool all_counted = std::abs(off - 1.0) < rounding;  // else parts are too thin for cells
  if (all_counted) wanted *= off;
  const double ratio = std::clamp(kept, (1.0 - tolerance) * wanted, (1.0 + tolerance) * wanted) / kept;
  Sides sides = sides_about(centre, lattice, threshold);
  if (all_counted) sides.missing += (true_volume - counted) * sides.share;
  const double even = std::cbrt(ratio), most = half_a_cell / sides.farthest.maxCoeff();
  lattice.scale = std::clamp(even, 1.0 - most, 1.0 + most);
  lattice.centroid = lattice.grid.origin + lattice.grid.spacing * centre;
  lattice.grid.origin += (1.0 - lattice.scale) * lattice.grid.spacing * centre;
  lattice.grid.spacing *= lattice.scale;
  const bool is_shell = sides.outward < sides.any_way / 3.0;
  if (is_shell || lattice.scale == even) return;
  const Vec3 missing = (ratio > 1.0 ? sides.missing : -sides.missing).cwiseMax(0.0);
  if (missing.sum() == 0.0) return;
  const double rest = ratio / std::pow(lattice.scale, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = half_a_cell / sides.farthest[axis];
    lattice.stretch[axis] =
        std::clamp(std::pow(rest, missing[axis] / missing.sum()), 1.0 - reach, 1.0 + reach);
  }
}

}  // namespace

Grid lattice_grid(const Box& box, int cells, double margin) {
  const double longest = box.size().maxCoeff();
  Grid grid;
  grid.spacing = longest / (cells + cells % 2);
  const int layers = static_cast<int>(std::ceil(margin / grid.spacing));
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = even_cells(box.size()[axis], grid.spacing) + 2 * layers;
  grid.origin = box.center() - 0.5 * grid.spacing * grid.size.cast<double>();
  return grid;
}

Lattice make_lattice(const PseudoVolume& volume, const Box& box, const LatticeOptions& options,
                     Progress& progress, double true_volume) {
  check(volume, box, options);
  progress.throw_if_cancelled();
  progress.report("lattice", 0.0);
  Lattice lattice;
  lattice.grid = lattice_grid(box, options.cells, volume.thresholds.d_in);
  lattice.contacts = options.contacts;
  lattice.density = densities(volume, lattice.grid);
  lattice.kept.resize(lattice.density.size());
  const auto threshold = static_cast<float>(options.density);
  std::ranges::transform(lattice.density, lattice.kept.begin(), [&](float d) { return d > threshold; });

  std::int64_t filled = 0;
  do {
    progress.throw_if_cancelled();
    if (options.fill_holes) fill_holes(lattice.grid, lattice.kept);
    filled = options.contacts == Contacts::fill ? fill_contacts(lattice.grid, lattice.kept) : 0;
  } while (filled > 0);

  progress.throw_if_cancelled();
  Components components = label_components(lattice.grid, lattice.kept);
  progress.throw_if_cancelled();
  lattice.components = static_cast<int>(components.size.size());
  if (options.largest_only && lattice.components > 1) {
    keep_largest(components, lattice.kept);
    lattice.components = 1;
  }
  progress.throw_if_cancelled();
  const ContactCounts contacts = count_contacts(lattice.grid, lattice.kept);
  progress.throw_if_cancelled();
  lattice.edge_contacts = contacts.edges, lattice.vertex_contacts = contacts.nodes;
  for (std::size_t c = 0; c < lattice.kept.size(); ++c) {
    lattice.kept_count += lattice.kept[c];
    lattice.filled_count += lattice.kept[c] != 0 && lattice.density[c] <= threshold;
  }
  if (options.fit_volume && lattice.kept_count > 0)
    fit_volume(options.density, true_volume / std::pow(lattice.grid.spacing, 3), lattice);
  return lattice;
}

}  // namespace isochor
