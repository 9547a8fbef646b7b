#include "core/parallel/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace isochor {
namespace {

thread_local bool inside_parallel_region = false;

struct Job {
  std::int64_t count = 0, grain = 1, chunks = 0;
  detail::ChunkFunction function = nullptr;
  void* context = nullptr;
  std::atomic<std::int64_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;

  void work() {
    inside_parallel_region = true;
    for (std::int64_t chunk = next.fetch_add(1); chunk < chunks; chunk = next.fetch_add(1)) {
      try {
        function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
      } catch (...) {
        std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next.store(chunks);
      }
    }
    inside_parallel_region = false;
  }
};

/// Workers that spin for a moment before they sleep: the solver's regions follow each other within
/// microseconds.
class ThreadPool {
 public:
  ~ThreadPool() { resize(1); }

  int size() const { return static_cast<int>(workers_.size()) + 1; }

  void resize(int threads) {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
      generation_.fetch_add(1);
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
    workers_.clear();
    stop_ = false;
    for (int i = 1; i < threads; ++i)
      workers_.emplace_back([this, seen = generation_.load()] { loop(seen); });
  }

  void run(Job& job) {
    {
      std::lock_guard lock(mutex_);
      job_ = &job;
      active_.store(static_cast<int>(workers_.size()));
      generation_.fetch_add(1);
    }
    wake_.notify_all();
    job.work();
    for (int spin = 0; active_.load() > 0; ++spin) {
      if (spin > spin_limit) std::this_thread::yield();
    }
  }

 private:
  static constexpr int spin_limit = 4000;

  void loop(std::uint64_t seen) {
    for (;;) {
      for (int spin = 0; spin < spin_limit && generation_.load() == seen; ++spin) {
      }
      Job* job = nullptr;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [&] { return generation_.load() != seen; });
        seen = generation_.load();
        if (stop_) return;
        job = job_;
      }
      job->work();
      active_.fetch_sub(1);
    }
  }

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<std::uint64_t> generation_{0};
  std::atomic<int> active_{0};
  Job* job_ = nullptr;
  bool stop_ = false;
};

/// One region at a time owns the workers; a region that finds them taken runs on its own thread.
std::mutex pool_mutex;
ThreadPool& pool() {
  static ThreadPool instance;
  return instance;
}
std::atomic<int> wanted_threads{0};

int cores() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

void set_thread_count(int count) {
  wanted_threads.store(count > 0 ? count : 0);
}

int thread_count() {
  const int wanted = wanted_threads.load();
  return wanted > 0 ? wanted : cores();
}

void detail::run_chunks(std::int64_t count, std::int64_t grain, ChunkFunction function, void* context) {
  if (count <= 0) return;
  grain = std::max<std::int64_t>(1, grain);
  const std::int64_t chunks = (count + grain - 1) / grain;
  const bool alone = chunks == 1 || inside_parallel_region || thread_count() == 1;
  std::unique_lock lock(pool_mutex, std::defer_lock);
  if (alone || !lock.try_lock()) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk)
      function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
    return;
  }
  if (pool().size() != thread_count()) pool().resize(thread_count());
  Job job;
  job.count = count, job.grain = grain, job.chunks = chunks, job.function = function, job.context = context;
  pool().run(job);
  if (job.failure) std::rethrow_exception(job.failure);
}

}  // namespace isochor
