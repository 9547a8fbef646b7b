#pragma once
#include <cstdint>

namespace isochor {

/// Eight features side by side, so that a vector of any instruction set loads a field at once and a tile is
/// one stretch of memory. Lengths are in voxels, from the grid's corner. Free lanes hold features so far away
/// that every test drops them.
///
/// Each feature brings conditions that all points closest to it meet, direction·x ≥ offset: they lie in its
/// Voronoi region. A block of voxels that breaks one can leave the feature out. A condition that a soup does
/// not offer is neutral (zero). Directions are floats, which tilts them by at most 6e-8; offsets are those of
/// the directions as rounded.
inline constexpr int tile_lanes = 8;

template <int conditions, class Offset>
struct RegionTile {
  float direction[conditions][3][tile_lanes];
  Offset offset[conditions][tile_lanes];
};

struct VertexTile {
  double position[3][tile_lanes];
  RegionTile<4, float> region;  ///< against the direction of incident edges
};

struct EdgeTile {
  double start[3][tile_lanes], direction[3][tile_lanes], length[tile_lanes];  ///< direction of length one
  RegionTile<2, float> region;  ///< in the plane of incident faces, away from them
};

struct FaceTile {
  double normal[3][tile_lanes], plane[tile_lanes];  ///< normal·x = plane
  RegionTile<3, double> region;                     ///< in the plane, inward across its sides
};

/// Corners of a cluster's triangles; free lanes repeat one.
struct CornerTile {
  static constexpr int lanes = 16;
  float position[3][lanes];
};

/// Features, as first tiles, of a few triangles that lie together. The next cluster's are the end.
struct Cluster {
  std::int32_t vertices, edges, faces, corners;
  float slack;  ///< ρ² of its largest triangle, ρ the radius of the smallest enclosing circle, or more
};

}  // namespace isochor
