#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/common/error.h"
#include "core/distance_field/fill.h"

namespace isochor {
namespace {

constexpr int most_voxels = 512, most_padding = 64;

void check_options(const DistanceFieldOptions& options) {
  const auto refuse = [](const char* pointer, int value, int least, int most) {
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} is {}, but must lie between {} and {}", pointer + 1, value, least, most),
                "choose a value in this range",
                {{pointer, "out of range", static_cast<double>(least), static_cast<double>(most)}});
  };
  if (options.voxels < least_voxels || options.voxels > most_voxels)
    refuse("/voxels", options.voxels, least_voxels, most_voxels);
  if (options.padding < 0 || options.padding > most_padding)
    refuse("/padding", options.padding, 0, most_padding);
}

void check_box(const Box& box) {
  const double longest = box.size().maxCoeff();
  if (longest < 0.0)
    throw Error(ErrorCode::empty_result, "the mesh has no triangle", "choose a mesh with triangles");
  const double farthest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (!(longest > 0.0))
    throw Error(ErrorCode::empty_result, "all triangles lie in one point",
                "check the mesh's units and export");
  if (longest < 1e-30)
    throw Error(ErrorCode::empty_result, fmt::format("the mesh is only {:g} units long", longest),
                "scale it up");
  // Beyond this, voxel centres could not be told apart to a hundred-thousandth of a voxel in double
  // precision.
  if (longest < 1e-8 * farthest)
    throw Error(
        ErrorCode::empty_result,
        fmt::format("the mesh is {:g} units long, but {:g} units away from the origin", longest, farthest),
        "move it to the origin");
}

}  // namespace

Grid distance_grid(const Box& box, const DistanceFieldOptions& options) {
  check_options(options);
  check_box(box);
  return grid_of_box(box, options);
}

Grid grid_of_box(const Box& box, const DistanceFieldOptions& options) {
  Grid grid;
  grid.spacing = box.size().maxCoeff() / options.voxels;
  for (int axis = 0; axis < 3; ++axis) {
    const int inner = std::max(1, static_cast<int>(std::ceil(box.size()[axis] / grid.spacing - 1e-9)));
    grid.size[axis] = inner + 2 * options.padding;
  }
  grid.origin = box.center() - 0.5 * grid.spacing * grid.size.cast<double>();
  return grid;
}

}  // namespace isochor
