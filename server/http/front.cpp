#include "server/http/front.h"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <new>

#include "server/job_queue/retry_allocation.h"
#include "server/memory_reserve.h"

namespace isochor {
namespace {

constexpr std::uint64_t listener_id = 0, waker_id = 1;
constexpr auto tick = std::chrono::milliseconds(50);

void watch(int epoll, int operation, int descriptor, std::uint32_t events, std::uint64_t id) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  epoll_ctl(epoll, operation, descriptor, &event);
}

}  // namespace

struct Front::Answers {
  Guarded<std::vector<std::pair<std::uint64_t, Response>>> ready;
};

Front::Front(Listener& listener, const Service& service, WorkerPool& workers, std::shared_ptr<Waker> waker,
             const FrontLimits& limits)
    : listener_(listener),
      service_(service),
      workers_(workers),
      waker_(std::move(waker)),
      limits_(limits),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      answers_(std::make_shared<Answers>()) {
  watch(epoll_, EPOLL_CTL_ADD, listener_.descriptor(), EPOLLIN, listener_id);
  watch(epoll_, EPOLL_CTL_ADD, waker_->descriptor(), EPOLLIN, waker_id);
}

Front::~Front() {
  entries_.clear();
  close(epoll_);
}

void Front::stop() {
  stop_ = true;
  waker_->wake();
}

void Front::run(std::chrono::milliseconds grace) {
  while (!stop_) turn();
  watch(epoll_, EPOLL_CTL_DEL, listener_.descriptor(), 0, listener_id);
  const auto end = Clock::now() + grace;
  while (draining() && Clock::now() < end) turn();
  entries_.clear();
}

/// What is still being sent, streams' last lines included.
bool Front::draining() const {
  return std::any_of(entries_.begin(), entries_.end(), [](const auto& entry) {
    const auto state = entry.second.connection->state();
    return state == Connection::State::writing || state == Connection::State::streaming;
  });
}

/// One connection's trouble, memory included, is its own end and nobody else's.
template <class Use>
void Front::with(Entry& entry, const Use& use) try {
  use(*entry.connection);
  update(entry);
} catch (const std::exception&) {
  entry.connection->close();
}

void Front::turn() {
  std::array<epoll_event, 256> events;
  const int count = epoll_wait(epoll_, events.data(), events.size(), static_cast<int>(tick.count()));
  const auto now = Clock::now();
  bool woken = false;
  for (int i = 0; i < count; ++i) {
    const epoll_event& event = events[static_cast<std::size_t>(i)];
    if (event.data.u64 == listener_id)
      accept_all(now);
    else if (event.data.u64 == waker_id)
      woken = true;
    else if (const auto found = entries_.find(event.data.u64); found != entries_.end())
      handle(found->second, event.events, now);
  }
  if (woken) {
    waker_->clear();
    take_answers(now);
    for (auto& [id, entry] : entries_) with(entry, [&](Connection& connection) { connection.on_wake(now); });
  }
  if (woken || now - last_tick_ >= tick) sweep(now);
}

void Front::accept_all(Clock::time_point now) try {
  for (;;) {
    const int socket = accept4(listener_.descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM))
      make_room();
    if (socket < 0) return;
    if (entries_.size() >= limits_.connections) make_room();
    const std::uint64_t id = next_id_++;
    Entry& entry = entries_[id];
    entry.connection = std::make_unique<Connection>(socket, id, limits_.connection, now);
    entry.interest = EPOLLIN;
    watch(epoll_, EPOLL_CTL_ADD, socket, EPOLLIN, id);
    handle(entry, EPOLLIN, now);
  }
} catch (const std::bad_alloc&) {
  // No memory for one more: it waits, or its peer goes away.
}

/// Ids grow with time: the first that has not finished its request is the oldest of the slow ones.
void Front::make_room() {
  const auto is_slow = [](const auto& entry) {
    const auto state = entry.second.connection->state();
    return state == Connection::State::head || state == Connection::State::lingering;
  };
  auto oldest = std::find_if(entries_.begin(), entries_.end(), is_slow);
  if (oldest == entries_.end()) oldest = entries_.begin();
  if (oldest != entries_.end()) entries_.erase(oldest);
}

void Front::handle(Entry& entry, std::uint32_t events, Clock::time_point now) {
  with(entry, [&](Connection& connection) {
    if ((events & EPOLLIN) != 0 && connection.on_readable(service_, now)) dispatch(connection, now);
    if ((events & EPOLLOUT) != 0 && !connection.closed()) connection.on_writable(now);
    if ((events & (EPOLLERR | EPOLLHUP)) != 0) connection.close();
  });
}

void Front::dispatch(Connection& connection, Clock::time_point now) {
  auto admission = std::make_shared<Admission>(connection.take_admission());
  if (admission->route->immediate) return connection.respond(service_.answer(*admission), now);
  const bool queued = workers_.submit(
      [admission, id = connection.id(), answers = answers_, waker = waker_, &service = service_] {
        Response response = service.answer(*admission);
        retry_allocation(
            [&] { answers->ready.with([&](auto& ready) { ready.emplace_back(id, std::move(response)); }); });
        waker->wake();
      });
  if (!queued)
    connection.respond(problem_response(Refusal{503, "busy", "too many requests are waiting", "try again"}),
                       now);
}

void Front::take_answers(Clock::time_point now) {
  auto ready = answers_->ready.with([](auto& waiting) { return std::exchange(waiting, {}); });
  for (auto& answer : ready)
    if (const auto found = entries_.find(answer.first); found != entries_.end())
      with(found->second, [&](Connection& connection) { connection.respond(std::move(answer.second), now); });
}

void Front::update(Entry& entry) {
  const Connection& connection = *entry.connection;
  if (connection.closed()) return;  // the descriptor left epoll as it was closed; sweep() drops the entry
  const std::uint32_t interest =
      (connection.wants_read() ? EPOLLIN : 0U) | (connection.wants_write() ? EPOLLOUT : 0U);
  if (interest == entry.interest) return;
  entry.interest = interest;
  watch(epoll_, EPOLL_CTL_MOD, connection.socket(), interest, connection.id());
}

/// Deadlines, bounds over all connections, and those that have closed.
void Front::sweep(Clock::time_point now) {
  last_tick_ = now;
  keep_memory_reserve();
  std::size_t heads = 0, bodies = 0;
  for (auto newest = entries_.rbegin(); newest != entries_.rend(); ++newest) {
    Entry& entry = newest->second;
    Connection& connection = *entry.connection;
    with(entry, [&](Connection& ticking) { ticking.on_tick(now); });
    heads += connection.buffered_head();
    bodies += connection.declared_body();
    if (heads > limits_.buffered_heads || bodies > limits_.declared_bodies) connection.close();  // the oldest
  }
  std::erase_if(entries_, [](const auto& entry) {
    return !entry.second.connection || entry.second.connection->closed();
  });
}

}  // namespace isochor
