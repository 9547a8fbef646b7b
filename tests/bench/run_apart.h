#pragma once
#include <functional>

#include "tests/bench/other_meshers.h"

namespace isochor {

/// What a mesher gave in a process of its own, so that it may crash or hang.
struct Apart {
  Tets mesh;
  double seconds = 0.0;  ///< of CPU
  std::string
      failure;  ///< its own reason, "crashed (signal 11)" or "nothing within 120 s"; empty when it gave tets
};
Apart run_apart(const std::function<Tets()>& mesher, int seconds_allowed);

}  // namespace isochor
