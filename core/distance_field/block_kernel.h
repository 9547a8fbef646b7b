#pragma once
#include <cstdint>
#include <span>

namespace isochor {

/// What a kernel reads and writes, as bare pointers: kernels are compiled once an instruction set and must
/// not instantiate anything that other translation units share (see block_kernels.cpp).
struct BlockTask {
  struct Vertices {
    const double* position[3];
    const float* away[4][3];
    const float* offset[4];
  } vertices;
  struct Edges {
    const double* start[3];
    const double* direction[3];
    const double* length;
    const float* away[2][3];
    const float* offset[2];
  } edges;
  struct Faces {
    const double* normal[3];
    const double* plane;
    const float* inward[3][3];
    const double* offset[3];
  } faces;
  struct Clusters {
    const std::int32_t *first_vertex, *first_edge, *first_face;
    const float* min[3];
    const float* max[3];
    std::int32_t count;
  } clusters;

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
