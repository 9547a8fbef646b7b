#include "server/http/front.h"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <new>
#include <span>

#include "server/job_queue/retry_allocation.h"
#include "server/memory_reserve.h"

namespace isochor {
namespace {

constexpr std::uint64_t listener_id = 1;
/// For connections that are ready, and for answers, before others are looked for.
constexpr auto handling_time = std::chrono::milliseconds(2);
/// For those that come, likewise.
constexpr auto accepting_time = std::chrono::milliseconds(4);

}  // namespace

Front::Front(Listener& listener, const Service& service, Workers& workers, std::shared_ptr<Waker> waker,
             const FrontLimits& limits)
    : listener_(listener),
      service_(service),
      most_{workers.most, {}},
      large_json_{workers.large_json, {}},
      waker_(std::move(waker)),
      limits_(limits),
      streams_(waker_),
      bodies_(service, waker_, limits.bodies),
      answers_(std::make_shared<Guarded<Answers>>()) {
  std::signal(SIGPIPE, SIG_IGN);  // sendfile(2) knows no MSG_NOSIGNAL
  connections_.watch(listener_.descriptor(), EPOLLIN, listener_id);
  connections_.watch(waker_->descriptor(), Waker::epoll_events, Waker::epoll_id);
}

void Front::stop() {
  stop_ = true;
  waker_->wake();
}

void Front::run(std::chrono::milliseconds grace) {
  while (!stop_) turn();
  connections_.forget(listener_.descriptor());
  const auto end = Clock::now() + grace;
  while (connections_.sending() && Clock::now() < end) turn();
  connections_.entries().clear();
  streams_.finish(end);
}

template <class Use>
void Front::with(ConnectionSet::Entry& entry, const Use& use) try {
  connections_.with(entry, use);
  if (!entry.connection) return;
  if (entry.connection->state() == Connection::State::streaming)
    streams_.adopt(connections_.release(entry));
  else if (entry.connection->awaits_file())
    bodies_.adopt(connections_.release(entry));
  else if (entry.connection->state() == Connection::State::parked)
    parked_.insert(entry.connection->id());
} catch (const std::bad_alloc&) {
  // No memory to hand one more on: it is closed.
}

void Front::turn() {
  const std::span<epoll_event> ready = connections_.wait();
  const auto now = Clock::now();
  bool woken = false;
  for (const epoll_event& event : ready) {
    if (event.data.u64 == listener_id) accept_some(now);
    if (event.data.u64 == Waker::epoll_id) woken = true;
  }
  if (woken) take_bodies(now);
  if (woken) take_answers(now);
  handle_ready(ready, now);
  hand_over();
  if (woken) wake_parked(now);
  if (now - last_tick_ >= connection_tick) sweep(now);
}

/// Who asks now does not wait for thousands before it, and they do not wait for ever: the newest come first
/// in one turn, the oldest in the next. Whose turn is not reached is ready again.
void Front::handle_ready(std::span<epoll_event> ready, Clock::time_point now) {
  newest_first_ = !newest_first_;
  std::sort(ready.begin(), ready.end(), [this](const epoll_event& a, const epoll_event& b) {
    return newest_first_ ? a.data.u64 > b.data.u64 : a.data.u64 < b.data.u64;
  });
  const auto end = Clock::now() + handling_time;
  for (const epoll_event& event : ready) {
    if (ConnectionSet::Entry* entry = connections_.find(event.data.u64)) handle(*entry, event.events, now);
    if (Clock::now() > end) return;
  }
}

/// Most have sent their request already. It is read at once, so that none who has asked is taken for a slow
/// one, and who comes later waits for no more than their reading.
void Front::accept_some(Clock::time_point now) try {
  const auto end = Clock::now() + accepting_time;
  do {
    const int socket = accept4(listener_.descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM))
      make_room();
    if (socket < 0) return;
    if (connections_.entries().size() >= limits_.connections) make_room();
    handle(
        connections_.add(std::make_unique<Connection>(Socket(socket), next_id_++, limits_.connection, now)),
        EPOLLIN, now);
  } while (Clock::now() < end);
} catch (const std::bad_alloc&) {
  // No memory for one more: it waits, or its peer goes away.
}

/// Ids grow with time: the first that has not finished its request is the oldest of the slow ones.
void Front::make_room() {
  connections_.drop_closed();
  const auto is_slow = [](const auto& entry) {
    const auto state = entry.second.connection->state();
    return state == Connection::State::head || state == Connection::State::lingering;
  };
  auto& entries = connections_.entries();
  if (entries.empty()) return streams_.make_room();
  const auto slow = std::find_if(entries.begin(), entries.end(), is_slow);
  entries.erase(slow == entries.end() ? entries.begin() : slow);
}

void Front::handle(ConnectionSet::Entry& entry, std::uint32_t events, Clock::time_point now) {
  if (!entry.connection) return;
  const std::uint64_t id = entry.connection->id();
  with(entry, [&](Connection& connection) {
    if ((events & EPOLLIN) != 0 && connection.on_readable(service_, now)) dispatch(connection, now);
    if ((events & EPOLLOUT) != 0 && !connection.closed()) connection.on_writable(now);
    if ((events & EPOLLRDHUP) != 0) connection.on_hangup();
    if ((events & (EPOLLERR | EPOLLHUP)) != 0) connection.close();
  });
  if (entry.connection) buffered_ += entry.connection->buffered();
  // At once, or what little it has left would keep the memory of its body apart.
  if (!entry.connection || entry.connection->closed()) connections_.entries().erase(id);
  if (buffered_ > limits_.buffered) sweep(now);
}

void Front::dispatch(Connection& connection, Clock::time_point now) {
  auto admission = std::make_shared<Admission>(connection.take_admission());
  if (admission->route->immediate) return connection.respond(service_.answer(*admission), now);
  const bool large_json = admission->route->body == BodyKind::json && admission->request.body.in_file();
  Line& line = large_json ? large_json_ : most_;
  if (line.tasks.size() >= line.workers.room())
    return connection.respond(
        problem_response(Refusal{503, "busy", "too many requests are waiting", "try again"}), now);
  line.tasks.emplace_back(
      [admission, id = connection.id(), answers = answers_, waker = waker_, &service = service_] {
        Response response = service.answer(*admission);
        Answers answer;
        retry_allocation([&] { answer.emplace_back(id, std::move(response)); });
        answers->with([&](Answers& ready) { ready.splice(ready.end(), answer); });
        waker->wake();
      });
}

void Front::hand_over() {
  for (Line* line : {&most_, &large_json_}) try {
      if (!line->tasks.empty()) line->workers.submit(line->tasks);
    } catch (const std::bad_alloc&) {
      waker_->wake();  // they wait for the next turn
    }
}

void Front::take_answers(Clock::time_point now) {
  answers_->with([this](Answers& ready) { taken_.splice(taken_.end(), ready); });
  const auto end = Clock::now() + handling_time;
  while (!taken_.empty()) {
    Answers one;
    one.splice(one.end(), taken_, taken_.begin());
    auto& answer = one.front();
    if (ConnectionSet::Entry* entry = connections_.find(answer.first))
      with(*entry, [&](Connection& connection) {
        connection.respond(std::move(answer.second), now);
        unsent_ += connection.unsent_body();
      });
    if (unsent_ > limits_.unsent_bodies) sweep(now);
    if (Clock::now() > end) return waker_->wake();  // the others come in the next turn
  }
}

/// Something has happened that their answers may have waited for.
void Front::wake_parked(Clock::time_point now) {
  std::erase_if(parked_, [&](std::uint64_t id) {
    ConnectionSet::Entry* entry = connections_.find(id);
    if (entry) with(*entry, [&](Connection& parked) { parked.on_wake(now); });
    return !entry || !entry->connection || entry->connection->state() != Connection::State::parked;
  });
}

/// Those whose bodies are whole, or have failed.
void Front::take_bodies(Clock::time_point now) {
  for (auto& connection : bodies_.take_read()) try {
      with(connections_.add(std::move(connection)), [&](Connection& read) {
        if (read.whole()) dispatch(read, now);
      });
    } catch (const std::bad_alloc&) {
      // No memory for it here: it is closed.
    }
}

/// Deadlines, bounds over all connections, and those that have closed. When
/// thousands are overdue at once, their refusals take several sweeps: others want to be answered, too.
void Front::sweep(Clock::time_point now) {
  constexpr int most_overdue = 64;
  int overdue = 0;
  last_tick_ = now;
  keep_memory_reserve();
  std::size_t unsent_bodies = 0, unsent_files = 0;
  buffered_ = 0;
  auto& entries = connections_.entries();
  for (auto newest = entries.rbegin(); newest != entries.rend(); ++newest)
    with(newest->second, [&](Connection& connection) {
      if (overdue < most_overdue && connection.on_tick(now)) ++overdue;
      buffered_ += connection.buffered();
      const bool crowded_out = (unsent_bodies > limits_.unsent_bodies && connection.unsent_body() > 0) ||
                               (unsent_files > limits_.unsent_files && connection.unsent_file() > 0);
      unsent_bodies += connection.unsent_body(), unsent_files += connection.unsent_file();
      const bool buffers_too_much = buffered_ > limits_.buffered && connection.buffered() > 0;
      if (!buffers_too_much && !crowded_out) return;
      buffered_ -= connection.buffered();
      connection.close();  // the oldest
    });
  unsent_ = unsent_bodies;
  connections_.drop_closed();
}

}  // namespace isochor
