#pragma once
#include <atomic>
#include <memory>
#include <new>
#include <utility>

#include "core/common/progress.h"
#include "server/job_queue/worker_pool.h"

namespace isochor {

/// Ends large values on a thread of its own, where nobody waits while gigabytes are freed, and gives their
/// memory back to the system.
class Disposal {
 public:
  /// A pointer whose value comes here once nobody holds it, whoever was the last; `lease` is let go when its
  /// memory is free again. It must not outlive this.
  template <class T>
  std::shared_ptr<T> share(std::unique_ptr<T> value, std::shared_ptr<const void> lease = nullptr) {
    return std::shared_ptr<T>(value.release(), [this, lease = std::move(lease)](T* unheld) mutable {
      take(std::unique_ptr<T>(unheld), std::move(lease));
    });
  }
  bool busy() const { return waiting_ > 0; }
  /// Until all that came here has ended: what is made next does not stand beside it in memory. Throws
  /// cancelled.
  void wait(const Progress& progress) const;

 private:
  template <class T>
  void take(std::unique_ptr<T> value, std::shared_ptr<const void> lease) noexcept try {
    end_later(std::shared_ptr<void>(std::move(value)), std::move(lease));
  } catch (const std::bad_alloc&) {
    // It ends here and now.
  }
  void end_later(std::shared_ptr<void> value, std::shared_ptr<const void> lease);

  std::atomic<int> waiting_{0};
  WorkerPool pool_{1};  ///< last: its thread uses the rest
};

}  // namespace isochor
