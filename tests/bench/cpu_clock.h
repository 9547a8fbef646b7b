#pragma once
#include <ctime>

namespace isochor {

/// Seconds of CPU that this process has used: with one thread at work its run time, whatever else the machine
/// does.
inline double cpu_seconds() {
  std::timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace isochor
