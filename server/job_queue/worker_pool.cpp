#include "server/job_queue/worker_pool.h"

#include <algorithm>
#include <iterator>

#include "server/job_queue/lower_priority.h"

namespace isochor {

WorkerPool::WorkerPool(int threads, std::size_t max_queued) : max_queued_(max_queued) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { loop(); });
}

WorkerPool::~WorkerPool() {
  std::deque<Task> came, waited;  // end outside the locks: what they hold may submit
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    came.swap(incoming_);
  }
  wake_.notify_one();
  {
    std::lock_guard lock(taking_);
    waited.swap(tasks_);
  }
  waited.clear();
  came.clear();
  for (std::thread& thread : threads_) thread.join();
}

bool WorkerPool::submit(Task task) {
  {
    std::lock_guard lock(mutex_);
    if (stop_ || room() == 0) return false;
    incoming_.push_back(std::move(task));
    ++queued_;
  }
  wake_.notify_one();
  return true;
}

void WorkerPool::submit(std::vector<Task>& tasks) {
  {
    std::lock_guard lock(mutex_);
    incoming_.insert(incoming_.end(), std::make_move_iterator(tasks.begin()),
                     std::make_move_iterator(tasks.end()));
    queued_ += tasks.size();
  }
  wake_.notify_one();
  tasks.clear();
}

std::size_t WorkerPool::room() const {
  return max_queued_ - std::min<std::size_t>(max_queued_, queued_);
}

WorkerPool::Task WorkerPool::take() {
  std::lock_guard taking(taking_);
  if (tasks_.empty()) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return stop_ || !incoming_.empty(); });
    tasks_.swap(incoming_);
  }
  if (stop_) return {};
  Task task = std::move(tasks_.front());
  tasks_.pop_front();
  --queued_;
  return task;
}

void WorkerPool::loop() {
  lower_priority();
  while (const Task task = take()) task();
}

}  // namespace isochor
