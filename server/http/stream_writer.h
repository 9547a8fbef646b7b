#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "server/http/connection_set.h"
#include "server/job_queue/guarded.h"
#include "server/stream/waker.h"

namespace isochor {

/// The streams, on a thread of their own: copying a frame to hundreds of viewers takes tens of milliseconds,
/// for which no other request has to wait.
class StreamWriter {
 public:
  explicit StreamWriter(std::shared_ptr<Waker> waker);
  ~StreamWriter();
  StreamWriter(const StreamWriter&) = delete;
  StreamWriter& operator=(const StreamWriter&) = delete;

  // From the front's thread.
  void adopt(std::unique_ptr<Connection> stream);
  void make_room();                    ///< closes the oldest
  void finish(Clock::time_point end);  ///< streams may end until then, and the rest is closed

 private:
  void run();
  void turn();
  void take_arrivals();
  void write_all(Clock::time_point now);

  std::shared_ptr<Waker> waker_;
  Guarded<std::vector<std::unique_ptr<Connection>>> arrivals_;
  std::atomic<bool> crowded_{false};
  std::atomic<Clock::time_point> end_{Clock::time_point::max()};
  ConnectionSet streams_;
  Clock::time_point last_tick_{};
  std::thread thread_;  ///< last: it uses the rest
};

}  // namespace isochor
