#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "server/http/body_reader.h"
#include "server/http/connection_set.h"
#include "server/http/listener.h"
#include "server/http/stream_writer.h"
#include "server/job_queue/guarded.h"
#include "server/job_queue/worker_pool.h"
#include "server/stream/waker.h"

namespace isochor {

struct FrontLimits {
  ConnectionLimits connection;
  std::size_t connections = 2048;
  std::size_t buffered = std::size_t{4} << 20;  ///< bytes in memory of requests that are not whole
  /// Bytes of answers that their readers have not taken, in memory and in files.
  std::size_t unsent_bodies = std::size_t{8} << 20, unsent_files = std::size_t{1} << 30;
  BodyLimits bodies;
};

/// Where requests are answered. The tree of a large JSON body takes many times its bytes, and tens of
/// milliseconds: one at a time, and small requests do not wait for it.
struct Workers {
  WorkerPool most{6, 512};  ///< enough for the few that really work at the same time; slow peers hold none
  WorkerPool large_json{1, 64};
};

/// Sockets on one side, request → response on the other: one thread and epoll. Workers see whole requests
/// only, so that slow peers cost a descriptor and no thread. Large bodies and streams have threads of their
/// own.
class Front {
 public:
  Front(Listener& listener, const Service& service, Workers& workers, std::shared_ptr<Waker> waker,
        const FrontLimits& limits = {});
  Front(const Front&) = delete;
  Front& operator=(const Front&) = delete;

  /// Until stop(): then streams may end within the time given, and the rest is closed.
  void run(std::chrono::milliseconds grace = std::chrono::milliseconds(250));
  void stop();  ///< from any thread

 private:
  template <class Use>
  void with(ConnectionSet::Entry& entry, const Use& use);
  void turn();
  void accept_some(Clock::time_point now);
  void handle_ready(std::span<epoll_event> ready, Clock::time_point now);
  void make_room();
  void handle(ConnectionSet::Entry& entry, std::uint32_t events, Clock::time_point now);
  void dispatch(Connection& connection, Clock::time_point now);
  void take_answers(Clock::time_point now);
  void take_bodies(Clock::time_point now);
  void sweep(Clock::time_point now);

  Listener& listener_;
  const Service& service_;
  Workers& workers_;
  std::shared_ptr<Waker> waker_;
  FrontLimits limits_;
  std::atomic<bool> stop_{false};
  std::uint64_t next_id_ = 2;  ///< 0 and 1 stand for the waker and the listener
  bool newest_first_ = false;
  int handled_ = 0;  ///< in the last turn
  ConnectionSet connections_;
  std::size_t buffered_ = 0;  ///< at most so many since the last sweep
  StreamWriter streams_;
  BodyReader bodies_;
  Clock::time_point last_tick_{};
  struct Answers;
  std::shared_ptr<Answers> answers_;  ///< shared with tasks that may outlive the front
};

}  // namespace isochor
