#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/common/progress.h"
#include "core/scene/scene.h"

namespace isochor {

/// A stiff or extreme scene and what must hold in it.
struct StabilityCase {
  std::string group, name;
  Scene scene;
  bool feasible_start = true;  ///< false: recovery may change the energy, so it is not judged
  bool feasible = true;        ///< false: the volume cannot be kept; it must say so and stay finite
  bool keeps_momentum = false;
  double stops_at = -1e300;         ///< no centre of mass may end below this height: nothing passes through
  double stiffness = 0.0, h = 0.0;  ///< where the case stands on the map k × h; h = 0: not on it
};

struct StabilityResult {
  std::string group, name;
  double stiffness = 0.0, h = 0.0;
  bool passed = false;
  std::string outcome;  ///< in words
  double tolerance = 0.0, max_cell_volume_error = 0.0, total_volume_error = 0.0;
  /// 1 + largest gain of energy over the start, relative to the start's kinetic and spring energy and the
  /// work that gravity can have done; NaN where it is not judged.
  double energy_ratio = 0.0;
  double momentum_drift = 0.0;  ///< relative, the larger of linear and angular; NaN where it is not judged
  std::int64_t inverted = 0;    ///< tets at the end
  int recoveries = 0, fallbacks = 0;
  double seconds = 0.0;
};

/// Quick is for every day (under two minutes on two cores), full adds the whole map and a million cells.
enum class StabilityExtent { quick, full };
std::vector<StabilityCase> stability_cases(StabilityExtent extent);

/// Runs one case to its end.
StabilityResult run_stability_case(const StabilityCase& test, const Progress& progress);

struct StabilityReport {
  std::vector<StabilityResult> results;
  bool complete = true;  ///< false when cancelled
  bool passed() const;
};
StabilityReport run_stability(StabilityExtent extent, Progress& progress,
                              const std::function<void(const StabilityResult&)>& on_result = {});

}  // namespace isochor
