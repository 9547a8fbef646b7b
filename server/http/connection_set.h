#pragma once
#include <sys/epoll.h>

#include <array>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <span>

#include "server/http/connection.h"

namespace isochor {

/// How often deadlines are looked at.
inline constexpr auto connection_tick = std::chrono::milliseconds(50);

/// The connections of one thread, by age, and the epoll that tells of them.
class ConnectionSet {
 public:
  ConnectionSet();
  ~ConnectionSet();
  ConnectionSet(const ConnectionSet&) = delete;
  ConnectionSet& operator=(const ConnectionSet&) = delete;

  /// What is not a connection; its id must be none of theirs.
  void watch(int descriptor, std::uint32_t events, std::uint64_t id) const;
  void forget(int descriptor) const;
  /// What is ready, waiting for it up to a tick.
  std::span<epoll_event> wait();

  struct Entry {
    std::unique_ptr<Connection> connection;  ///< null: handed on
    std::uint32_t interest = 0;
  };
  Entry& add(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> release(Entry& entry) const;
  Entry* find(std::uint64_t id);
  std::map<std::uint64_t, Entry>& entries() { return entries_; }
  const std::map<std::uint64_t, Entry>& entries() const { return entries_; }
  void drop_closed();
  /// Whether an answer is still being sent, streams' last lines included.
  bool sending() const;

  /// One connection's trouble, memory included, is its own end and nobody else's.
  template <class Use>
  void with(Entry& entry, const Use& use) const {
    if (!entry.connection) return;
    try {
      use(*entry.connection);
      update(entry);
    } catch (const std::exception&) {
      entry.connection->close();
    }
  }

 private:
  void update(Entry& entry) const;

  int epoll_;
  std::array<epoll_event, 8192> events_;
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace isochor
