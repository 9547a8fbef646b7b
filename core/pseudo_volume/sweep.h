#pragma once
#include "core/pseudo_volume/votes.h"
#include "core/pseudo_volume/voxel_masks.h"

namespace isochor {

/// What the sweeps read, and the votes of the crossing rules that are wanted (null: not wanted).
struct Sweep {
  const FieldWindow& window;
  const VoxelMasks& masks;
  Votes* at_threshold = nullptr;
  Votes* at_maximum = nullptr;
};

/// Rays that move from row to row: all directions (x, step_y, step_z) with x among those given. Rows that
/// such rays meet one after the other form a path, and paths share no row.
struct RowSweep {
  int step_y = 0, step_z = 0;
  std::vector<int> steps_x;  ///< of −1, 0, 1; at most three
};

/// Casts the rays of all paths, 64 of them in a word, and adds their votes.
void sweep_rows(const Sweep& sweep, const RowSweep& directions, const Progress& progress);

/// Casts the rays of the directions (±1, 0, 0), which stay in their row.
void sweep_along_rows(const Sweep& sweep, const Progress& progress);

}  // namespace isochor
