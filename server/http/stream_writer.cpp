#include "server/http/stream_writer.h"

#include <utility>

namespace isochor {

StreamWriter::StreamWriter(std::shared_ptr<Waker> waker) : waker_(std::move(waker)) {
  streams_.watch(waker_->descriptor(), Waker::epoll_events, Waker::epoll_id);
  thread_ = std::thread([this] { run(); });
}

StreamWriter::~StreamWriter() {
  finish(Clock::now());
}

void StreamWriter::adopt(std::unique_ptr<Connection> stream) {
  arrivals_.with([&](auto& waiting) { waiting.push_back(std::move(stream)); });
  waker_->wake();
}

void StreamWriter::make_room() {
  crowded_ = true;
  waker_->wake();
}

void StreamWriter::finish(Clock::time_point end) {
  if (!thread_.joinable()) return;
  end_ = end;
  waker_->wake();
  thread_.join();
}

void StreamWriter::run() {
  while (end_.load() == Clock::time_point::max() || (streams_.sending() && Clock::now() < end_.load()))
    turn();
  streams_.entries().clear();
}

void StreamWriter::turn() {
  const auto ready = streams_.wait();
  const auto now = Clock::now();
  bool woken = false;
  for (const epoll_event& event : ready) {
    if (event.data.u64 == Waker::epoll_id) {
      woken = true;
    } else if (ConnectionSet::Entry* entry = streams_.find(event.data.u64)) {
      streams_.with(*entry, [&](Connection& stream) {
        if ((event.events & EPOLLIN) != 0) stream.discard_input();
        if ((event.events & EPOLLOUT) != 0 && !stream.closed()) stream.on_writable(now);
        if ((event.events & (EPOLLERR | EPOLLHUP)) != 0) stream.close();
      });
    }
  }
  if (woken || now - last_tick_ >= connection_tick) write_all(now);
}

/// New frames, and deadlines.
void StreamWriter::write_all(Clock::time_point now) {
  last_tick_ = now;
  take_arrivals();
  if (crowded_.exchange(false) && !streams_.entries().empty())
    streams_.entries().begin()->second.connection->close();
  for (auto& [id, entry] : streams_.entries())
    streams_.with(entry, [&](Connection& stream) { stream.on_tick(now); });
  streams_.drop_closed();
}

void StreamWriter::take_arrivals() {
  auto arrivals = arrivals_.with([](auto& waiting) { return std::exchange(waiting, {}); });
  for (auto& stream : arrivals) try {
      streams_.add(std::move(stream));
    } catch (const std::bad_alloc&) {
      // No memory for one more stream: it is closed.
    }
}

}  // namespace isochor
