#pragma once
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "server/http/connection_set.h"
#include "server/job_queue/guarded.h"
#include "server/stream/waker.h"

namespace isochor {

struct BodyLimits {
  std::size_t connections = 256;             ///< that send at the same time
  std::size_t bytes = std::size_t{2} << 30;  ///< in files, with those of requests that are being answered
};

/// Receives the bodies that go into files, on a thread of its own: a disk may make it wait, and nobody else.
class BodyReader {
 public:
  /// `front` is woken when there is something to take.
  BodyReader(const Service& service, std::shared_ptr<Waker> front, const BodyLimits& limits);
  ~BodyReader();
  BodyReader(const BodyReader&) = delete;
  BodyReader& operator=(const BodyReader&) = delete;

  // From the front's thread.
  void adopt(std::unique_ptr<Connection> sender);
  /// Those whose bodies are whole, and those that are to be told why not.
  std::vector<std::unique_ptr<Connection>> take_read();

 private:
  using Connections = std::vector<std::unique_ptr<Connection>>;
  void run();
  void turn();
  void take_arrivals(Clock::time_point now);
  void read(ConnectionSet::Entry& entry, Clock::time_point now);
  void keep_to_limits(Clock::time_point now);
  void hand_back();

  const Service& service_;
  std::shared_ptr<Waker> front_;
  const BodyLimits limits_;
  Waker waker_;
  Guarded<Connections> arrivals_, read_;
  std::atomic<bool> stop_{false};
  ConnectionSet senders_;
  std::thread thread_;  ///< last: it uses the rest
};

}  // namespace isochor
