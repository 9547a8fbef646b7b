#include "server/http/connection.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "server/http/http_library.h"

namespace isochor {
namespace {

constexpr std::size_t read_size = 64 * 1024;
/// Most heads are shorter, and what comes after one waits in memory for its turn.
constexpr std::size_t head_read_size = 4 * 1024;
constexpr int reads_a_turn = 32;
constexpr auto turn = std::chrono::milliseconds(2);
/// Of what a refused sender still sends, so that it gets to read why: clients send a body whole before they
/// read.
constexpr std::size_t max_discarded = 8 << 20;

/// An assignment would keep its memory.
void let_go(std::string& text) {
  std::string().swap(text);
}

/// −1: nothing there now; 0: the peer has ended.
ssize_t receive(int socket, char* to, std::size_t size) {
  const ssize_t got = recv(socket, to, size, 0);
  if (got >= 0) return got;
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? -1 : 0;
}

}  // namespace

void Socket::close() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

Connection::Connection(Socket socket, std::uint64_t id, const ConnectionLimits& limits, Clock::time_point now)
    : socket_(std::move(socket)), id_(id), limits_(limits), opened_(now), deadline_(now + limits.head) {}

void Connection::close() {
  if (state_ == State::closed) return;
  socket_.close();
  state_ = State::closed;
  on_hangup();
  stream_.reset();
  pending_.reset();
  output_ = {};
  let_go(input_);
  admission_ = {};
}

bool Connection::on_readable(const Service& service, Clock::time_point now) {
  if (state_ == State::head) return read_head(service, now);
  if (state_ == State::body) return read_body(now);
  discard_input();
  return false;
}

bool Connection::read_head(const Service& service, Clock::time_point now) {
  // One for all connections of a thread: a head that comes in one piece takes no memory of its own, which
  // would leave holes between what stays.
  thread_local std::array<char, max_head_bytes + head_read_size> buffer;
  std::size_t size = input_.copy(buffer.data(), input_.size()), length = std::string::npos;
  while (length == std::string::npos && size <= max_head_bytes) {
    const ssize_t got = receive(socket_.descriptor(), buffer.data() + size, head_read_size);
    if (got == 0) close();
    if (got < 0) input_.assign(buffer.data(), size);
    if (got <= 0) return false;
    length = head_length({buffer.data(), size + static_cast<std::size_t>(got)}, size);
    size += static_cast<std::size_t>(got);
  }
  const std::string_view input(buffer.data(), size);
  if (length > max_head_bytes) {  // or npos: not there yet
    respond(problem_response(Refusal{431, "head_too_large", "the head exceeds 16 KiB", ""}), now);
    return false;
  }
  auto admitted = service.admit(input.substr(0, length));
  if (auto* refusal = std::get_if<Response>(&admitted)) {
    respond(std::move(*refusal), now);
    return false;
  }
  admission_ = std::move(std::get<Admission>(admitted));
  head_only_ = admission_.head_only;
  if (admission_.expects_continue)
    send(socket_.descriptor(), "HTTP/1.1 100 Continue\r\n\r\n", 25, MSG_NOSIGNAL | MSG_DONTWAIT);
  state_ = State::body;
  deadline_ = now + limits_.body;
  input_ = input.substr(length);
  return whole() || (!body().in_file() && read_body(now));
}

/// All that is there, as far as others do not have to wait: a body whose sender is gone is let go before the
/// next one grows.
bool Connection::read_body(Clock::time_point now) try {
  Body& body = admission_.request.body;
  const std::string begun = std::exchange(input_, {});
  body.append(std::string_view(begun).substr(0, body.missing()));
  std::array<char, read_size> buffer;
  for (int reads = 0; reads < reads_a_turn && body.missing() > 0; ++reads) {
    const ssize_t got = receive(socket_.descriptor(), buffer.data(), std::min(buffer.size(), body.missing()));
    if (got == 0) close();
    if (got <= 0) return false;
    body.append({buffer.data(), static_cast<std::size_t>(got)});
  }
  return whole();
} catch (const RefusalException& full) {
  respond(problem_response(full.refusal), now);
  return false;
}

void Connection::on_hangup() {
  if (abandoned_) *abandoned_ = true;
}

void Connection::discard_input() {
  std::array<char, read_size> buffer;
  const ssize_t got = receive(socket_.descriptor(), buffer.data(), buffer.size());
  if (got > 0) discarded_ += static_cast<std::size_t>(got);
  if (got == 0 || discarded_ > max_discarded) close();
}

Admission Connection::take_admission() {
  abandoned_ = std::make_shared<std::atomic<bool>>(false);
  admission_.request.abandoned = abandoned_;
  state_ = State::working;
  let_go(input_);
  return std::move(admission_);
}

void Connection::respond(Response response, Clock::time_point now) {
  if (closed()) return;
  if (response.pending) {
    pending_ = std::move(response.pending);
    state_ = State::parked;
    return on_wake(now);
  }
  pending_.reset();
  admission_ = {};
  let_go(input_);
  add_security_headers(response);
  output_ = {};
  output_.head = format_head(response);
  if (!head_only_) {
    output_.body = std::move(response.body);
    output_.file = std::move(response.file);
    stream_ = std::move(response.stream);
  }
  state_ = stream_ ? State::streaming : State::writing;
  opened_ = now;
  deadline_ = now + limits_.stalled_write;
  if (!stream_) on_writable(now);
}

void Connection::on_writable(Clock::time_point now) {
  has_more_ = false;
  write(now);
  if (state_ == State::streaming && !has_output()) pull(now);
}

void Connection::on_wake(Clock::time_point now) {
  if (state_ == State::parked) {
    if (auto answer = pending_->poll(now >= pending_->deadline)) respond(std::move(*answer), now);
  } else if (state_ == State::streaming && !has_output()) {
    pull(now);
  }
}

/// As much as the socket takes.
ssize_t Connection::send_some() const {
  if (output_.sent >= output_.in_memory())
    return output_.file->send(socket_.descriptor(), output_.sent - output_.in_memory());
  std::array<iovec, 3> parts;
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = output_.remaining(parts);
  return sendmsg(socket_.descriptor(), &message, MSG_NOSIGNAL);
}

/// Until the reader is behind, or others want their turn.
void Connection::write(Clock::time_point now) {
  const auto turn_end = Clock::now() + turn;
  while (has_output()) {
    if (Clock::now() > turn_end) return;
    const ssize_t sent = send_some();
    if (sent == 0) return close();  // the file is shorter than it was
    if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return;
    if (sent < 0) return close();
    output_.sent += static_cast<std::size_t>(sent);
    deadline_ = now + limits_.stalled_write;
  }
  output_ = {};
  if (state_ == State::writing) finish(now);
}

std::size_t Connection::Output::remaining(std::array<iovec, 3>& parts) const {
  std::size_t count = 0, skip = sent;
  for (const std::string_view part :
       {std::string_view(head), body ? std::string_view(*body) : std::string_view(),
        std::string_view(tail)}) {
    if (skip < part.size()) parts[count++] = {const_cast<char*>(part.data()) + skip, part.size() - skip};
    skip -= std::min(skip, part.size());
  }
  return count;
}

void Connection::pull(Clock::time_point now) {
  const auto turn_end = Clock::now() + turn;
  while (state_ == State::streaming && !has_output()) {
    StreamPiece piece = stream_->next(now);
    if (piece.empty()) {
      if (!stream_->finished()) return;
      state_ = State::writing;
      output_.tail = "0\r\n\r\n";
    } else {
      output_.head = fmt::format("{:x}\r\n", piece.size()) + piece.own;
      output_.body = std::move(piece.shared);
      output_.tail = std::move(piece.end) + "\r\n";
    }
    write(now);
    has_more_ = Clock::now() > turn_end;
    if (has_more_) return;
  }
}

/// The peer may still be sending: closing at once would reset the connection and take the answer with it.
void Connection::finish(Clock::time_point now) {
  shutdown(socket_.descriptor(), SHUT_WR);
  state_ = State::lingering;
  stream_.reset();
  deadline_ = now + limits_.linger;
}

bool Connection::on_tick(Clock::time_point now) {
  if (state_ == State::parked || state_ == State::streaming) on_wake(now);
  if (state_ == State::working || state_ == State::parked) return false;
  if (state_ == State::streaming && !has_output()) return false;
  const bool overdue =
      now >= deadline_ || (state_ == State::writing && now >= opened_ + limits_.whole_answer);
  if (overdue) time_out(now);
  return overdue;
}

void Connection::time_out(Clock::time_point now) {
  const bool reads = (state_ == State::head && !input_.empty()) || state_ == State::body;
  if (!reads) return close();
  respond(problem_response(Refusal{408, "timeout", "the request did not arrive in time", ""}), now);
}

}  // namespace isochor
