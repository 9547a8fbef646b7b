#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "core/common/progress.h"

namespace isochor {

/// A progress that is cancelled with an outer one, and once so many seconds have passed. For work that has
/// to end before its next step, in a thread that only waits.
class Deadline {
 public:
  Deadline(const Progress& outer, double seconds);
  ~Deadline();
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  const Progress& progress() const { return progress_; }
  bool passed() const { return passed_; }

 private:
  std::atomic<bool> cancelled_{false}, passed_{false};
  Progress progress_{{}, &cancelled_};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool over_ = false;
  std::thread watch_;
};

}  // namespace isochor
