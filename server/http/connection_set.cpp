#include "server/http/connection_set.h"

#include <unistd.h>

#include <algorithm>
#include <array>

namespace isochor {
namespace {

void control(int epoll, int operation, int descriptor, std::uint32_t events, std::uint64_t id) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  epoll_ctl(epoll, operation, descriptor, &event);
}

std::uint32_t interest_of(const Connection& connection) {
  return (connection.wants_read() ? EPOLLIN : 0U) | (connection.wants_write() ? EPOLLOUT : 0U) |
         (connection.wants_hangup() ? EPOLLRDHUP : 0U);
}

}  // namespace

ConnectionSet::ConnectionSet() : epoll_(epoll_create1(EPOLL_CLOEXEC)) {}

ConnectionSet::~ConnectionSet() {
  entries_.clear();
  close(epoll_);
}

void ConnectionSet::watch(int descriptor, std::uint32_t events, std::uint64_t id) const {
  control(epoll_, EPOLL_CTL_ADD, descriptor, events, id);
}

void ConnectionSet::forget(int descriptor) const {
  control(epoll_, EPOLL_CTL_DEL, descriptor, 0, 0);
}

std::span<epoll_event> ConnectionSet::wait() {
  const int count =
      epoll_wait(epoll_, events_.data(), events_.size(), static_cast<int>(connection_tick.count()));
  return {events_.data(), static_cast<std::size_t>(std::max(count, 0))};
}

ConnectionSet::Entry& ConnectionSet::add(std::unique_ptr<Connection> connection) {
  Entry& entry = entries_[connection->id()];
  entry.interest = interest_of(*connection);
  watch(connection->socket(), entry.interest, connection->id());
  entry.connection = std::move(connection);
  return entry;
}

std::unique_ptr<Connection> ConnectionSet::release(Entry& entry) const {
  forget(entry.connection->socket());
  return std::move(entry.connection);
}

ConnectionSet::Entry* ConnectionSet::find(std::uint64_t id) {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second;
}

void ConnectionSet::drop_closed() {
  std::erase_if(entries_, [](const auto& entry) {
    return !entry.second.connection || entry.second.connection->closed();
  });
}

bool ConnectionSet::sending() const {
  return std::any_of(entries_.begin(), entries_.end(), [](const auto& entry) {
    const Connection* connection = entry.second.connection.get();
    return connection && (connection->state() == Connection::State::writing ||
                          connection->state() == Connection::State::streaming);
  });
}

void ConnectionSet::update(Entry& entry) const {
  const Connection& connection = *entry.connection;
  if (connection.closed()) return;  // its descriptor left epoll as it was closed
  const std::uint32_t interest = interest_of(connection);
  if (interest == entry.interest) return;
  entry.interest = interest;
  control(epoll_, EPOLL_CTL_MOD, connection.socket(), interest, connection.id());
}

}  // namespace isochor
