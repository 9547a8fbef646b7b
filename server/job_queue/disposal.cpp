#include "server/job_queue/disposal.h"

#include <chrono>
#include <thread>

#include "server/memory_reserve.h"

namespace isochor {

void Disposal::wait(const Progress& progress) const {
  while (busy()) {
    progress.throw_if_cancelled();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void Disposal::end_later(std::shared_ptr<void> value, std::shared_ptr<const void> lease) {
  /// Counts for as long as the task lives, also where it is dropped.
  struct Count {
    std::atomic<int>& waiting;
    explicit Count(std::atomic<int>& counter) : waiting(counter) { ++waiting; }
    ~Count() { --waiting; }
    Count(const Count&) = delete;
    Count& operator=(const Count&) = delete;
  };
  pool_.submit([value = std::move(value), lease = std::move(lease),
                count = std::make_shared<Count>(waiting_)]() mutable {
    value.reset();
    return_free_memory();
    lease.reset();
    count.reset();
  });
}

}  // namespace isochor
