#include "core/parallel/deadline.h"

#include <algorithm>
#include <chrono>

namespace isochor {

Deadline::Deadline(const Progress& outer, double seconds) {
  using Clock = std::chrono::steady_clock;
  constexpr double century = 3e9;  // what a clock can count to
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(std::min(seconds, century)));
  watch_ = std::thread([this, outer, end] {
    std::unique_lock lock(mutex_);
    while (!over_ && !cancelled_) {
      passed_ = Clock::now() >= end;
      cancelled_ = passed_ || outer.cancelled();
      ended_.wait_until(lock, std::min(end, Clock::now() + std::chrono::milliseconds(50)));
    }
  });
}

Deadline::~Deadline() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  ended_.notify_one();
  watch_.join();
}

}  // namespace isochor
