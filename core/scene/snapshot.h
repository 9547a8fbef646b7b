#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "core/common/types.h"

namespace isochor {

/// What a frame reports; SI units. Momentum is that of the dynamic bodies about the world's origin.
struct Metrics {
  double total_volume_error = 0.0;     ///< |ΣV − ΣV0| / ΣV0 over the deformable bodies
  double max_cell_volume_error = 0.0;  ///< max |V − V0| / V0 over the cells
  std::int64_t worst_cell = -1;        ///< where, in the body worst_body
  int worst_body = -1;
  int iterations = 0;  ///< of the volume solver, summed over the frame's substeps
  int substeps = 0;
  double h = 0.0;  ///< smallest substep, seconds
  double step_ms = 0.0;
  std::int64_t inverted = 0;
  double max_penetration = 0.0;  ///< metres
  std::int64_t contacts = 0;
  int recoveries =
      0;  ///< substeps that needed the inversion rule, or whose contacts no implicit solve balanced
  int fallbacks = 0;  ///< substeps whose projection left SHAKE's directions
  /// False: the tolerance could not be met, worst_cell says where; or deformable bodies are in others or
  /// themselves by over 1e-3 of a cell.
  bool feasible = true;
  double kinetic_energy = 0.0, potential_energy = 0.0;  ///< potential: springs and gravity
  Vec3 linear_momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();
};

struct BodySnapshot {
  int id = 0;
  std::vector<Vec3> positions;   ///< deformable: a tet vertex
  Vec3 position = Vec3::Zero();  ///< rigid: its pose
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// A frame: a value of its own, safe to hand to other threads.
struct Snapshot {
  std::int64_t seq = 0;
  double t = 0.0;
  Metrics metrics;
  std::vector<BodySnapshot> bodies;
};

}  // namespace isochor
