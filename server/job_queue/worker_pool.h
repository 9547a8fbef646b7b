#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isochor {

/// Threads that run tasks in the order given. Tasks must not throw.
class WorkerPool {
 public:
  explicit WorkerPool(int threads, std::size_t max_queued = SIZE_MAX);
  ~WorkerPool();  ///< drops what is queued, waits for what runs
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// false: the queue is full.
  bool submit(std::function<void()> task);

 private:
  void loop();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> tasks_;
  const std::size_t max_queued_;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace isochor
