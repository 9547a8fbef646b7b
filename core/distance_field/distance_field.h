#pragma once
#include <cstdint>
#include <vector>

#include "core/common/progress.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

struct DistanceFieldOptions {
  int voxels = 128;  ///< along the box's longest edge, 16 to 512
  int padding = 4;   ///< voxels added on each side; pseudo_volume asks for field_padding
  std::int64_t max_bytes = std::int64_t{4}
                           << 30;  ///< refused above: the distances and what they are made from
  bool operator==(const DistanceFieldOptions&) const = default;
};

/// Unsigned distance to the soup at every voxel centre, in model units, dense and exact to 1e-5 voxels
/// (or half a float ulp where that is more).
struct DistanceField {
  Grid grid;
  std::vector<float> distance;  ///< grid.count()
  float max_distance = 0.0F;
  int padding = 0;  ///< voxels around the soup's box
};

/// Every stride-th voxel of a field: as exact, on a grid whose voxels are that much larger.
DistanceField thinned(const DistanceField& field, int stride);

/// The grid alone: cubic voxels, centred on the soup's box. Throws invalid_argument.
Grid distance_grid(const Box& box, const DistanceFieldOptions& options);

/// Throws over_budget before anything large is allocated, cancelled.
DistanceField make_distance_field(const TriangleSoup& soup, const DistanceFieldOptions& options,
                                  Progress& progress);

}  // namespace isochor
