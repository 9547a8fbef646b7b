#include "server/job_queue/lower_priority.h"

#include <unistd.h>

namespace isochor {

void lower_priority() {
  constexpr int step = 5;                           // a third of the weight
  [[maybe_unused]] const int reached = nice(step);  // of this thread alone, on Linux
}

}  // namespace isochor
