#pragma once
#include <cstdint>

namespace isochor {

/// What the last step did.
struct RigidMetrics {
  std::int64_t contacts = 0;     ///< points that pressed
  double max_penetration = 0.0;  ///< metres, at the end of the step
  double max_joint_error = 0.0;  ///< metres (radians for axes), at the end of the step
  int iterations = 0;            ///< Newton rounds of the solver, both stages
  bool converged = true;
  bool gave_up = false;  ///< some bodies that began in each other were left there
};

}  // namespace isochor
