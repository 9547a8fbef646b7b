#include "core/pipeline/shortfall.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isochor {
namespace {

constexpr double largest_volume_error = 0.25, largest_in_pieces = 0.1;
constexpr int most_cells = 256;
const char* const drop_strays = "drop stray parts that lie far away, or give the parts one by one";

/// What a box around the input holds that is grown by two cells on all sides, but for its edges and corners.
double most_volume(const Vec3& extents, double cell) {
  const auto [a, b, c] = std::array{extents.x(), extents.y(), extents.z()};
  return a * b * c + 2.0 * cell * 2.0 * (a * b + b * c + c * a);
}

int even(double at_least) {
  return 2 * static_cast<int>(std::ceil(0.5 * std::min(at_least, 1e6)));
}

}  // namespace

std::string wall_advice(const Model& model) {
  const double longest = model.input->bounds.size().maxCoeff();
  const double wall = 2.0 * model.enclosed_volume / model.input->area;  // the distance of a plate's two sides
  const int cells = even(2.0 * longest / wall);
  if (!(wall > 0.0) || cells > most_cells)
    return fmt::format(
        "its walls are about {:.2g} thick, which takes cells of half of that, and the finest are {:.2g}: "
        "thicken the walls, or give its parts one by one",
        wall, longest / most_cells);
  if (cells <= model.options.lattice.cells)
    return model.quality.volume > model.enclosed_volume
               ? "its cells are small enough, but its thresholds thicken it: try the preset solid"
               : "try more cells and voxels";
  return fmt::format("its walls are about {:.2g} thick, so try {} cells and {} voxels", wall, cells,
                     2 * cells);
}

std::optional<int> finer_cells(const Model& model) {
  const int cells = 2 * model.options.lattice.cells;
  return model.enclosed_volume > 0.0 && cells <= most_cells ? std::optional(cells) : std::nullopt;
}

std::string coverage_advice(const Model& model) {
  const auto cells = finer_cells(model);
  if (!cells) return "try the preset thin or more cells";
  if (2 * *cells <= model.options.voxels) return fmt::format("try {} cells", *cells);
  return fmt::format("try {} cells and {} voxels", *cells, 2 * *cells);
}

std::optional<Shortfall> shortfall(const Model& model) {
  const QualitySummary& quality = model.quality;
  const MeshReport& input = *model.input;
  if (quality.coverage < sufficient_coverage)
    return Shortfall{fmt::format("it covers only {:.1f} % of the input's area", 100.0 * quality.coverage),
                     coverage_advice(model)};
  // A thin plate that falls to pieces may be covered all over, and lack a part of its volume only.
  const bool in_pieces = model.lattice->components > input.components;
  if (model.volume_error() > (in_pieces ? largest_in_pieces : largest_volume_error))
    return Shortfall{
        fmt::format("{}its volume is {:.4g}, but the closed input encloses {:.4g}",
                    in_pieces ? fmt::format("it falls into {} parts, and ", model.lattice->components) : "",
                    quality.volume, model.enclosed_volume),
        wall_advice(model)};
  const double most = most_volume(model.size.extents, model.lattice->grid.spacing);
  if (quality.volume > most)
    return Shortfall{
        fmt::format("its volume is {:.4g}, but the box of its input, two cells thicker, holds {:.4g}",
                    quality.volume, most),
        drop_strays};
  return input_below_a_cell(model);
}

std::optional<Shortfall> input_below_a_cell(const Model& model) {
  const double area = model.input->area, face = std::pow(model.lattice->grid.spacing, 2);
  if (area >= face) return std::nullopt;
  return Shortfall{fmt::format("its input has an area of {:.4g}, and the face of a cell {:.4g}", area, face),
                   drop_strays};
}

}  // namespace isochor
