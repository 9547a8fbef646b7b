#include "server/memory_reserve.h"

#include <malloc.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>

namespace isochor {
namespace {

constexpr std::size_t reserve_bytes = std::size_t{4} << 20;
constexpr int max_tries = 3;

std::atomic<void*> reserve{nullptr};

/// Called by operator new, which tries again when this returns. It does not say for which allocation: calls
/// that follow each other at once are for the same.
void use_reserve() {
  using Clock = std::chrono::steady_clock;
  thread_local Clock::time_point last{};
  thread_local int tries = 0;
  if (Clock::now() - last > std::chrono::microseconds(5)) tries = 0;
  if (++tries > max_tries) throw std::bad_alloc();
  std::free(reserve.exchange(nullptr));
  last = Clock::now();
}

}  // namespace

void keep_memory_reserve() {
  std::set_new_handler(use_reserve);
  if (reserve.load()) return;
  void* expected = nullptr;
  void* fresh = std::malloc(reserve_bytes);
  if (!reserve.compare_exchange_strong(expected, fresh)) std::free(fresh);
}

void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace isochor
