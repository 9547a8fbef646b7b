#include "core/parallel/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

thread_local bool inside_parallel_region = false;  ///< or in an AloneScope

/// Hints the core that this is a spin loop.
void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/// Workers that spin for a moment before they sleep: the solver's regions follow each other within
/// microseconds. Chunks are drawn from a ticket that carries the region's number and those that are left, so
/// the caller waits for drawn chunks only, never for a worker that the system has put aside. The caller draws
/// from the front and the first worker from the back: regions over the same arrays find them in their core's
/// cache.
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
    for (int i = 1; i < threads; ++i)
      workers_.emplace_back(
          [this, seen = number(), end = i % 2 ? End::back : End::front] { loop(seen, end); });
  }

  void run(std::int64_t count, std::int64_t grain, Work work, detail::ChunkFunction function, void* context) {
    region_.count.store(count, std::memory_order_relaxed);
    region_.grain.store(grain, std::memory_order_relaxed);
    const std::int64_t chunks = (count + grain - 1) / grain,
                       most = work == Work::alike ? turns_a_thread(chunks) * size() : most_draws,
                       batch = (chunks + most - 1) / most, draws = (chunks + batch - 1) / batch;
    region_.chunks.store(chunks, std::memory_order_relaxed);
    region_.batch.store(batch, std::memory_order_relaxed);
    region_.function.store(function, std::memory_order_relaxed);
    region_.context.store(context, std::memory_order_relaxed);
    region_.progress.store(CancelScope::progress(), std::memory_order_relaxed);
    done_.store(0, std::memory_order_relaxed);
    failed_.store(false, std::memory_order_relaxed);
    const std::uint64_t next = (number() + 1) & 0xffffffff;
    // In one order for all threads with sleepers_ in loop(): one of both sees the other.
    ticket_.store(next << 32 | static_cast<std::uint64_t>(draws));
    if (sleepers_.load() > 0) {
      { std::lock_guard lock(mutex_); }
      wake_.notify_all();
    }
    const auto begin = Clock::now();
    const std::int64_t drawn = draw(next, End::front);
    const auto end = Clock::now();
    for (int spin = 0; done_.load(std::memory_order_acquire) < draws; ++spin) {
      if (spin < spin_limit)
        pause();
      else
        std::this_thread::yield();
    }
    if (drawn > 0) judge_wait((end - begin) / drawn, Clock::now() - end);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  /// Whether workers have lately kept the caller waiting for more than a chunk of its own takes.
  bool is_held_up() const { return held_up_ && Clock::now() < held_up_until_; }

 private:
  enum class End { front, back };
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t cache_line = 64;
  static constexpr std::int64_t most_draws = 0xffff;
  /// Of chunks alike. One that is put aside holds up no more than its turn.
  static std::int64_t turns_a_thread(std::int64_t chunks) { return chunks < 64 ? 1 : 4; }
  static constexpr int spin_limit = 4000;  ///< some 150 µs

  std::uint64_t number() const { return ticket_.load() >> 32; }

  /// Something else has the worker's core: regions go without workers for ten times what waiting has cost, so
  /// that about a tenth of the time is lost by trying; not for long, lest chunks that differ do it.
  void judge_wait(Clock::duration chunk, Clock::duration wait) {
    constexpr Clock::duration usual = std::chrono::microseconds(50), longest = std::chrono::milliseconds(20);
    const Clock::duration lost = wait - 2 * chunk - usual;
    held_up_ = lost > Clock::duration::zero();
    if (held_up_) held_up_until_ = Clock::now() + std::min(10 * lost, longest);
  }

  /// Does batches of chunks of the region while it has any. Returns how many.
  std::int64_t draw(std::uint64_t number, End from) {
    std::int64_t drawn = 0;
    inside_parallel_region = true;
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    while (ticket >> 32 == number) {
      const std::uint64_t first = ticket >> 16 & 0xffff, end = ticket & 0xffff;
      if (first == end) break;
      // The exchange succeeds only while the region has some left: then what is read here belongs to it.
      const std::int64_t count = region_.count.load(std::memory_order_relaxed),
                         grain = region_.grain.load(std::memory_order_relaxed),
                         batch = region_.batch.load(std::memory_order_relaxed),
                         chunks = region_.chunks.load(std::memory_order_relaxed);
      const detail::ChunkFunction function = region_.function.load(std::memory_order_relaxed);
      void* const context = region_.context.load(std::memory_order_relaxed);
      const Progress* const progress = region_.progress.load(std::memory_order_relaxed);
      const std::uint64_t rest = from == End::front ? ticket + (1U << 16) : ticket - 1;
      if (!ticket_.compare_exchange_weak(ticket, rest, std::memory_order_acq_rel)) continue;
      const auto mine = static_cast<std::int64_t>(from == End::front ? first : end - 1);
      try {
        for (std::int64_t chunk = mine * batch; chunk < std::min(chunks, (mine + 1) * batch); ++chunk) {
          if (progress) progress->throw_if_cancelled();
          if (failed_.load(std::memory_order_relaxed)) break;
          function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
        }
      } catch (...) {
        std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        failed_.store(true, std::memory_order_relaxed);
      }
      done_.fetch_add(1, std::memory_order_release);
      ++drawn;
      ticket = ticket_.load(std::memory_order_acquire);
    }
    inside_parallel_region = false;
    return drawn;
  }

  void loop(std::uint64_t seen, End from) {
    for (;;) {
      for (int spin = 0; spin < spin_limit && number() == seen; ++spin) pause();
      if (number() == seen) {
        std::unique_lock lock(mutex_);
        sleepers_.fetch_add(1);
        wake_.wait(lock, [&] { return stop_ || number() != seen; });
        sleepers_.fetch_sub(1);
        if (stop_) return;
      }
      seen = number();
      draw(seen, from);
    }
  }

  bool held_up_ = false;  ///< with the time below, the caller's
  Clock::time_point held_up_until_;
  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<int> sleepers_{0};
  bool stop_ = false;
  std::exception_ptr failure_;  ///< the first one; the chunks not yet begun are skipped then
  std::atomic<bool> failed_{false};

  /// What a region is. A cache line of its own: workers that spin on the ticket do not slow down its writing.
  struct alignas(cache_line) Region {
    std::atomic<std::int64_t> count{0}, grain{1}, chunks{0}, batch{1};
    std::atomic<detail::ChunkFunction> function{nullptr};
    std::atomic<void*> context{nullptr};
    std::atomic<const Progress*> progress{nullptr};  ///< of the caller's scope
  };
  Region region_;
  /// The region's number in the upper half; below it, 16 bits each, the first batch left and the end of those
  /// left.
  alignas(cache_line) std::atomic<std::uint64_t> ticket_{0};
  alignas(cache_line) std::atomic<std::int64_t> done_{0};  ///< batches
};

/// One region at a time owns the workers; a region that finds them taken runs on its own thread.
std::mutex pool_mutex;
ThreadPool& pool() {
  static ThreadPool instance;
  return instance;
}
std::atomic<int> wanted_threads{0};

/// Asked once: the C library reads a file for the answer, which takes as long as a small region.
int cores() {
  static const int count = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return count;
}

}  // namespace

void set_thread_count(int count) {
  wanted_threads.store(count > 0 ? count : 0);
}

int thread_count() {
  const int wanted = wanted_threads.load();
  return wanted > 0 ? wanted : cores();
}

AloneScope::AloneScope(bool alone) : before_(inside_parallel_region) {
  inside_parallel_region |= alone;
}

AloneScope::~AloneScope() {
  inside_parallel_region = before_;
}

void detail::run_chunks(std::int64_t count, std::int64_t grain, Work work, ChunkFunction function,
                        void* context) {
  if (count <= 0) return;
  grain = std::max<std::int64_t>(1, grain);
  const std::int64_t chunks = (count + grain - 1) / grain;
  const bool alone = chunks == 1 || inside_parallel_region || thread_count() == 1;
  std::unique_lock lock(pool_mutex, std::defer_lock);
  if (!alone && lock.try_lock() && pool().is_held_up()) lock.unlock();  // for what the body calls in turn
  if (!lock.owns_lock()) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) {
      throw_if_scope_cancelled();
      function(context, chunk * grain, std::min(count, (chunk + 1) * grain));
    }
    return;
  }
  if (pool().size() != thread_count()) pool().resize(thread_count());
  pool().run(count, grain, work, function, context);
}

}  // namespace isochor
