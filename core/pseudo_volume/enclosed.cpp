#include "core/pseudo_volume/enclosed.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "core/mesh_input/axis_lines.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

constexpr std::int64_t most_tries = 100'000'000;  ///< rows in the boxes of all triangles
constexpr double on_surface = 1e-3;               ///< voxels; more than the rows are off their centres

struct Crossing {
  float x;             ///< voxels
  std::int32_t sense;  ///< of the triangle along the row, ±1
};

/// The rows of voxel centres, moved a little off any regular pattern of the input.
AxisLines rows_of(const Grid& grid) {
  return {0, grid.origin + grid.spacing * Vec3(0.0, 0.5 + 4.142e-4, 0.5 + 5.321e-4), grid.spacing};
}

/// Sets the bits of a row between the crossings, in order, that enclose it.
void fill(std::span<const Crossing> crossings, Enclosing rule, std::span<const float> distance, float least,
          std::uint64_t* bits) {
  int depth = 0;  // within how many surfaces
  for (std::size_t n = 0; n + 1 < crossings.size(); ++n) {
    depth += rule == Enclosing::winding ? crossings[n].sense : 1 - 2 * depth;
    if (depth == 0) continue;
    const auto first_behind = [&](float x) {
      return std::clamp(static_cast<int>(std::ceil(x - 0.5F)), 0, static_cast<int>(distance.size()));
    };
    for (int i = first_behind(crossings[n].x); i < first_behind(crossings[n + 1].x); ++i)
      bits[i / 64] |= std::uint64_t{distance[i] > least} << i % 64;
  }
}

}  // namespace

std::optional<BitVolume> enclosed_voxels(const TriangleSoup& soup, const DistanceField& field, Enclosing rule,
                                         const Progress& progress) {
  const Grid& grid = field.grid;
  BitVolume inside(grid.size);
  const AxisLines rows = rows_of(grid);
  if (rows.tries(soup) > most_tries) return std::nullopt;
  std::vector<std::int64_t> first(inside.rows() + 1, 0);
  for (const Triangle& t : cancellable(soup.triangles))
    rows.for_crossings(soup, t, [&](int j, int k, double, int) { ++first[inside.row_index(j, k) + 1]; });
  progress.throw_if_cancelled();
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Crossing> crossings;
  cancellable_resize(crossings, static_cast<std::size_t>(first.back()));
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  for (const Triangle& t : cancellable(soup.triangles))
    rows.for_crossings(soup, t, [&](int j, int k, double depth, int sense) {
      crossings[next[inside.row_index(j, k)]++] = {static_cast<float>(depth / grid.spacing), sense};
    });
  progress.throw_if_cancelled();
  const auto least = static_cast<float>(on_surface * grid.spacing);
  parallel_for(inside.rows(), 256, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = begin; row < end; ++row) {
      const std::span along = std::span(crossings).subspan(first[row], first[row + 1] - first[row]);
      std::ranges::sort(along, {}, &Crossing::x);
      const std::span distance = std::span(field.distance).subspan(row * inside.size.x(), inside.size.x());
      fill(along, rule, distance, least, inside.bits.data() + inside.words * row);
    }
  });
  return inside;
}

}  // namespace isochor
