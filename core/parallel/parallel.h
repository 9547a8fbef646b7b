#pragma once
#include <cstdint>
#include <type_traits>

namespace isochor {

/// Threads used by parallel_for, the calling one included. 0 asks for one per core. The results of every
/// function of this library are the same bits for any number.
void set_thread_count(int count);
int thread_count();

/// How chunks are dealt out. Those alike, of some microseconds, in as few turns as there are threads: a turn
/// costs a fifth of a microsecond.
enum class Work { uneven, alike };

/// While it lives, parallel_for runs on this thread alone, if so asked.
class AloneScope {
 public:
  explicit AloneScope(bool alone);
  ~AloneScope();
  AloneScope(const AloneScope&) = delete;
  AloneScope& operator=(const AloneScope&) = delete;

 private:
  bool before_;
};

namespace detail {
using ChunkFunction = void (*)(void* context, std::int64_t begin, std::int64_t end);
void run_chunks(std::int64_t count, std::int64_t grain, Work work, ChunkFunction function, void* context);
}  // namespace detail

/// Calls body(begin, end) for the chunks [0,grain), [grain,2·grain), … of [0,count), on all threads. The cut
/// depends on count and grain only, never on the threads, so a sum kept a chunk and added in chunk order is
/// reproducible. A nested call runs on its own thread. The first exception is rethrown after all have ended.
template <class Body>
void parallel_for(std::int64_t count, std::int64_t grain, Body&& body, Work work = Work::uneven) {
  using Function = std::remove_reference_t<Body>;
  detail::run_chunks(
      count, grain, work,
      [](void* context, std::int64_t begin, std::int64_t end) {
        (*static_cast<Function*>(context))(begin, end);
      },
      const_cast<void*>(static_cast<const void*>(&body)));
}

}  // namespace isochor
