#pragma once
#include <chrono>
#include <new>
#include <thread>

namespace isochor {

/// For the few steps that must not be lost when memory runs out for a moment (an answer handed over, a job's
/// end): tries again for a second, then lets bad_alloc go on.
template <class Step>
void retry_allocation(const Step& step) {
  for (int tries = 0; tries < 1000; ++tries) {
    try {
      return step();
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  step();
}

}  // namespace isochor
