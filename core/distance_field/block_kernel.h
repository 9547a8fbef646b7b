#pragma once
#include <cstdint>
#include <span>

#include "core/distance_field/feature_tiles.h"

namespace isochor {

/// What a kernel reads and writes, as bare pointers: kernels are compiled once an instruction set and must
/// not instantiate anything that other translation units share (see block_kernels.cpp).
struct BlockTask {
  const VertexTile* vertices;
  const EdgeTile* edges;
  const FaceTile* faces;
  const CornerTile* corners;
  const Cluster* clusters;
  const float *box_min[3], *box_max[3];  ///< of the clusters
  std::int32_t cluster_count;

  int size[3];        ///< of the grid
  double spacing;     ///< model units of a voxel
  float* distance;    ///< of the grid, model units
  void* scratch;      ///< scratch_bytes of the kernel, aligned to 64
  const void* owner;  ///< of cancelled
  bool (*cancelled)(const void* owner);
};

/// Fills cubes of voxels, root_edge³ each, with the distance to the closest feature.
struct BlockKernel {
  static constexpr int root_edge = 32;

  const char* name;
  std::int64_t (*scratch_bytes)(std::int32_t clusters);
  /// corner: the cube's first voxel. largest is raised to the largest distance. False when cancelled.
  bool (*fill)(const BlockTask& task, const int* corner, float& largest);
};

/// Those that this processor can run, best first.
std::span<const BlockKernel> block_kernels();

}  // namespace isochor
