#pragma once
#include <atomic>
#include <cstdint>
#include <list>
#include <memory>
#include <set>
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
  std::size_t connections = 8192;
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
  void hand_over();
  void take_answers(Clock::time_point now);
  void wake_parked(Clock::time_point now);
  void take_bodies(Clock::time_point now);
  void sweep(Clock::time_point now);

  Listener& listener_;
  const Service& service_;
  /// Tasks go to workers together, at the end of a turn: each one would have to wait for the worker that the
  /// one before has woken.
  struct Line {
    WorkerPool& workers;
    std::vector<WorkerPool::Task> tasks;
  };
  Line most_, large_json_;
  std::shared_ptr<Waker> waker_;
  FrontLimits limits_;
  std::atomic<bool> stop_{false};
  std::uint64_t next_id_ = 2;  ///< 0 and 1 stand for the waker and the listener
  bool newest_first_ = false;
  ConnectionSet connections_;
  std::size_t buffered_ = 0;  ///< at most so many since the last sweep
  StreamWriter streams_;
  BodyReader bodies_;
  std::size_t unsent_ = 0;  ///< the same of bytes that readers have not taken
  std::set<std::uint64_t> parked_;
  Clock::time_point last_tick_{};
  using Answers = std::list<std::pair<std::uint64_t, Response>>;
  std::shared_ptr<Guarded<Answers>> answers_;  ///< shared with tasks that may outlive the front
  Answers taken_;                              ///< of them, not yet handled
};

}  // namespace isochor
