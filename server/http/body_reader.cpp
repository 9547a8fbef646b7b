#include "server/http/body_reader.h"

#include <fmt/format.h>

#include <new>
#include <utility>

#include "server/job_queue/retry_allocation.h"

namespace isochor {
namespace {

Refusal gives_way(const BodyLimits& limits) {
  return {503, "busy",
          fmt::format("more than {} MiB, or {} bodies, are being sent at once: the oldest gave way",
                      limits.bytes >> 20, limits.connections),
          "send it again, and fewer at a time"};
}

}  // namespace

BodyReader::BodyReader(const Service& service, std::shared_ptr<Waker> front, const BodyLimits& limits)
    : service_(service), front_(std::move(front)), limits_(limits) {
  senders_.watch(waker_.descriptor(), Waker::epoll_events, Waker::epoll_id);
  thread_ = std::thread([this] { run(); });
}

BodyReader::~BodyReader() {
  stop_ = true;
  waker_.wake();
  thread_.join();
}

void BodyReader::adopt(std::unique_ptr<Connection> sender) {
  arrivals_.with([&](Connections& waiting) { waiting.push_back(std::move(sender)); });
  waker_.wake();
}

BodyReader::Connections BodyReader::take_read() {
  return read_.with([](Connections& waiting) { return std::exchange(waiting, {}); });
}

void BodyReader::run() {
  while (!stop_) turn();
}

void BodyReader::turn() {
  const auto ready = senders_.wait();
  const auto now = Clock::now();
  bool woken = false;
  for (const epoll_event& event : ready) {
    if (event.data.u64 == Waker::epoll_id)
      woken = true;
    else if (ConnectionSet::Entry* entry = senders_.find(event.data.u64))
      read(*entry, now);
  }
  if (woken) take_arrivals(now);
  for (auto& [id, entry] : senders_.entries())
    senders_.with(entry, [&](Connection& sender) { sender.on_tick(now); });
  hand_back();
}

void BodyReader::take_arrivals(Clock::time_point now) {
  auto arrivals = arrivals_.with([](Connections& waiting) { return std::exchange(waiting, {}); });
  for (auto& sender : arrivals) try {
      read(senders_.add(std::move(sender)), now);
    } catch (const std::bad_alloc&) {
      // No memory for one more: it is closed.
    }
}

void BodyReader::read(ConnectionSet::Entry& entry, Clock::time_point now) {
  senders_.with(entry, [&](Connection& sender) {
    if (sender.awaits_file()) sender.on_readable(service_, now);
  });
  keep_to_limits(now);
}

void BodyReader::keep_to_limits(Clock::time_point now) {
  std::size_t count = senders_.entries().size();
  for (auto& [id, entry] : senders_.entries()) {
    if (count <= limits_.connections && Body::bytes_in_files() <= limits_.bytes) return;
    --count;
    senders_.with(entry, [&](Connection& oldest) {
      if (oldest.awaits_file()) oldest.respond(problem_response(gives_way(limits_)), now);
    });
  }
}

void BodyReader::hand_back() {
  bool some = false;
  for (auto& [id, entry] : senders_.entries()) {
    if (!entry.connection || entry.connection->closed() || entry.connection->awaits_file()) continue;
    auto sender = senders_.release(entry);
    retry_allocation(
        [&] { read_.with([&](Connections& waiting) { waiting.push_back(std::move(sender)); }); });
    some = true;
  }
  senders_.drop_closed();
  if (some) front_->wake();
}

}  // namespace isochor
