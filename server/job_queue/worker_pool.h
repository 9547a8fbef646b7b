#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace isochor {

/// Threads of lower priority that run tasks in the order given. Tasks must not throw.
class WorkerPool {
 public:
  using Task = std::function<void()>;

  explicit WorkerPool(int threads, std::size_t max_queued = SIZE_MAX);
  ~WorkerPool();  ///< drops what is queued, waits for what runs
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// false: the queue is full.
  bool submit(Task task);
  /// All of them, whatever the room, and empties it. Where it throws nothing has changed.
  void submit(std::vector<Task>& tasks);
  /// How many more the queue would take; it becomes less by submitting only.
  std::size_t room() const;

 private:
  void loop();
  Task take();  ///< none: the pool ends

  std::mutex mutex_;  ///< of what comes in, so that who submits does not wait for workers that take
  std::condition_variable wake_;
  std::deque<Task> incoming_;
  std::atomic<std::size_t> queued_{0};
  const std::size_t max_queued_;
  std::atomic<bool> stop_{false};
  std::mutex taking_;  ///< held by one worker, which waits for tasks while there are none
  std::deque<Task> tasks_;
  std::vector<std::thread> threads_;
};

}  // namespace isochor
