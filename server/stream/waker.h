#pragma once
#include <sys/epoll.h>

#include <cstdint>

namespace isochor {

/// Tells the threads that serve connections that something changed: a job ended, a frame came, an answer is
/// ready. Any thread may wake; wakes that meet become one.
class Waker {
 public:
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  void wake() const;
  int descriptor() const { return descriptor_; }
  /// Edge-triggered: each epoll that watches it is told of each wake, and nobody has to clear it.
  static constexpr std::uint32_t epoll_events = EPOLLIN | EPOLLET;
  static constexpr std::uint64_t epoll_id = 0;  ///< in each epoll; connections have others

 private:
  int descriptor_;
};

}  // namespace isochor
