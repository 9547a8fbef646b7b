#include "core/parallel/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

thread_local bool inside_parallel_region = false;

/// Hints the core that this is a spin loop.
void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/// Workers that spin for a moment before they sleep: the solver's regions follow each other within
/// microseconds. Chunks are drawn from a ticket that carries the region's number and how many are left, so
/// the caller waits for drawn chunks only, never for a worker that the system has put aside.
class ThreadPool {
 public:
  ~ThreadPool() { resize(1); }

  int size() const { return static_cast<int>(workers_.size()) + 1; }

  void resize(int threads) {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
    workers_.clear();
    stop_ = false;
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this, seen = region()] { loop(seen); });
  }

  void run(std::int64_t count, std::int64_t grain, std::int64_t chunks, detail::ChunkFunction function,
           void* context) {
    count_.store(count, std::memory_order_relaxed);
    grain_.store(grain, std::memory_order_relaxed);
    chunks_.store(chunks, std::memory_order_relaxed);
    function_.store(function, std::memory_order_relaxed);
    context_.store(context, std::memory_order_relaxed);
    progress_.store(CancelScope::progress(), std::memory_order_relaxed);
    done_.store(0, std::memory_order_relaxed);
    failed_.store(false, std::memory_order_relaxed);
    const std::uint64_t number = (region() + 1) & most_chunks;
    // In one order for all threads with sleepers_ in loop(): one of both sees the other.
    ticket_.store(number << chunk_bits | static_cast<std::uint64_t>(chunks));
    if (sleepers_.load() > 0) {
      { std::lock_guard lock(mutex_); }
      wake_.notify_all();
    }
    draw(number);
    for (int spin = 0; done_.load(std::memory_order_acquire) < chunks; ++spin) {
      if (spin < spin_limit)
        pause();
      else
        std::this_thread::yield();
    }
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  static constexpr std::uint64_t most_chunks = 0xffffffff;

 private:
  static constexpr int chunk_bits = 32;
  static constexpr int spin_limit = 1000;  ///< some 40 µs

  std::uint64_t region() const { return ticket_.load() >> chunk_bits; }

  /// Does chunks of the region while it has any.
  void draw(std::uint64_t number) {
    inside_parallel_region = true;
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    while (ticket >> chunk_bits == number && (ticket & most_chunks) > 0) {
      // The exchange succeeds only while the region has chunks left: then what is read here belongs to it.
      const std::int64_t chunk = chunks_.load(std::memory_order_relaxed) -
                                 static_cast<std::int64_t>(ticket & most_chunks),
                         count = count_.load(std::memory_order_relaxed),
                         grain = grain_.load(std::memory_order_relaxed);
      const detail::ChunkFunction function = function_.load(std::memory_order_relaxed);
      void* const context = context_.load(std::memory_order_relaxed);
      const Progress* const progress = progress_.load(std::memory_order_relaxed);
      if (!ticket_.compare_exchange_weak(ticket, ticket - 1, std::memory_order_acq_rel)) continue;
      try {
        if (progress) progress->throw_if_cancelled();
        if (!failed_.load(std::memory_order_relaxed))
          function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
      } catch (...) {
        std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        failed_.store(true, std::memory_order_relaxed);
      }
      done_.fetch_add(1, std::memory_order_release);
      ticket = ticket_.load(std::memory_order_acquire);
    }
    inside_parallel_region = false;
  }

  void loop(std::uint64_t seen) {
    for (;;) {
      for (int spin = 0; spin < spin_limit && region() == seen; ++spin) pause();
      if (region() == seen) {
        std::unique_lock lock(mutex_);
        sleepers_.fetch_add(1);
        wake_.wait(lock, [&] { return stop_ || region() != seen; });
        sleepers_.fetch_sub(1);
        if (stop_) return;
      }
      seen = region();
      draw(seen);
    }
  }

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<int> sleepers_{0};
  bool stop_ = false;
  std::exception_ptr failure_;  ///< the first one; the chunks not yet begun are skipped then
  std::atomic<bool> failed_{false};

  std::atomic<std::uint64_t> ticket_{0};  ///< the region's number, and below it the chunks left
  std::atomic<std::int64_t> done_{0};     ///< chunks
  std::atomic<std::int64_t> count_{0}, grain_{1}, chunks_{0};
  std::atomic<detail::ChunkFunction> function_{nullptr};
  std::atomic<void*> context_{nullptr};
  std::atomic<const Progress*> progress_{nullptr};  ///< of the caller's scope
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
  const bool alone = chunks == 1 || chunks > static_cast<std::int64_t>(ThreadPool::most_chunks) ||
                     inside_parallel_region || thread_count() == 1;
  std::unique_lock lock(pool_mutex, std::defer_lock);
  if (alone || !lock.try_lock()) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) {
      throw_if_scope_cancelled();
      function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
    }
    return;
  }
  if (pool().size() != thread_count()) pool().resize(thread_count());
  pool().run(count, grain, chunks, function, context);
}

}  // namespace isochor
