#pragma once
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "server/http/service.h"

namespace isochor {

using Clock = std::chrono::steady_clock;

/// Bounds in time. A stalled reader is one whose kernel buffer took nothing for that long.
struct ConnectionLimits {
  std::chrono::milliseconds head{5000}, body{60000}, stalled_write{30000}, whole_answer{300000}, linger{1000};
};

/// Owns a descriptor.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() { close(); }
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  void close();
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// One request on one socket, as a state machine of one thread at a time (the front's, then for a stream its
/// writer's): it never blocks, and holds no thread while a peer is slow.
class Connection {
 public:
  enum class State { head, body, working, parked, writing, streaming, lingering, closed };

  Connection(Socket socket, std::uint64_t id, const ConnectionLimits& limits, Clock::time_point now);
  ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Reads what is there. True when the request is whole: the caller answers at once, or takes it to a
  /// worker. A body that goes to a file is left for the next call.
  bool on_readable(const Service& service, Clock::time_point now);
  void on_writable(Clock::time_point now);
  /// The peer has ended its side: what works for it may stop.
  void on_hangup();
  /// What a peer sends after its request is ignored; the reader of a stream that ends its side is gone.
  void discard_input();
  /// Deadlines: whether one has passed.
  bool on_tick(Clock::time_point now);
  /// Something changed elsewhere: asks the parked answer, or for the next piece of the stream.
  void on_wake(Clock::time_point now);

  /// The whole request, for a worker; the connection waits for respond().
  Admission take_admission();
  /// Begins to write the answer; a stream waits for on_writable().
  void respond(Response response, Clock::time_point now);
  void close();

  State state() const { return state_; }
  bool closed() const { return state_ == State::closed; }
  /// Its body goes to a file, and is not whole yet.
  bool awaits_file() const { return state_ == State::body && body().in_file() && !whole(); }
  bool whole() const { return state_ == State::body && body().missing() == 0; }
  bool wants_read() const {
    return state_ == State::head || state_ == State::body || state_ == State::streaming ||
           state_ == State::lingering;
  }
  bool wants_hangup() const { return state_ == State::working && !*abandoned_; }
  bool wants_write() const { return has_output() || has_more_; }
  std::uint64_t id() const { return id_; }
  int socket() const { return socket_.descriptor(); }
  Clock::time_point opened() const { return opened_; }
  /// In memory, of a request that is not whole yet.
  std::size_t buffered() const {
    return state_ == State::head || state_ == State::body ? input_.size() + body().bytes_in_memory() : 0;
  }
  /// This reader's share of the body that it takes, in memory, and in a file.
  std::size_t unsent_body() const { return share(output_.body); }
  std::size_t unsent_file() const { return share(output_.file); }

 private:
  /// At most three pieces are under way: an own one, a shared one, and the chunk's end.
  struct Output {
    std::string head;
    SharedBytes body;
    std::string tail;
    std::shared_ptr<const NamelessFile> file;  ///< after all of them
    std::size_t sent = 0;
    std::size_t in_memory() const { return head.size() + (body ? body->size() : 0) + tail.size(); }
    std::size_t size() const { return in_memory() + (file ? file->size() : 0); }
    std::size_t remaining(std::array<iovec, 3>& parts) const;
  };

  template <class T>
  static std::size_t share(const std::shared_ptr<T>& bytes) {
    return bytes ? bytes->size() / static_cast<std::size_t>(std::max(1L, bytes.use_count())) : 0;
  }

  bool has_output() const { return output_.sent < output_.size(); }
  bool read_head(const Service& service, Clock::time_point now);
  bool read_body(Clock::time_point now);
  const Body& body() const { return admission_.request.body; }
  void write(Clock::time_point now);
  ssize_t send_some() const;
  void pull(Clock::time_point now);
  void finish(Clock::time_point now);
  void time_out(Clock::time_point now);

  Socket socket_;
  std::uint64_t id_;
  const ConnectionLimits& limits_;
  State state_ = State::head;
  bool head_only_ = false;
  bool has_more_ = false;  ///< the stream was interrupted to let others have their turn
  std::size_t discarded_ = 0;
  Clock::time_point opened_, deadline_;
  std::string input_;
  Admission admission_;
  std::shared_ptr<std::atomic<bool>> abandoned_;  ///< shared with a request that was taken
  Output output_;
  std::shared_ptr<ByteSource> stream_;
  std::shared_ptr<PendingAnswer> pending_;
};

}  // namespace isochor
