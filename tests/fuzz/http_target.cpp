#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

#include "server/http/connection.h"
#include "server/messages/json.h"
#include "server/messages/report_request.h"
#include "server/messages/request_messages.h"
#include "tests/fuzz/targets.h"

namespace isochor {
namespace {

Response done() {
  return Response::json(R"({"status":"ok"})");
}

Route reading(std::string_view pattern, void (*read)(const Request&), BodyKind body = BodyKind::json) {
  return {.method = "POST",
          .pattern = pattern,
          .operation = "read",
          .summary = "",
          .handler =
              [read](const Request& request) {
                read(request);
                return done();
              },
          .answers = {},
          .body = body};
}

/// The guard and the readers of bodies as the server has them; nothing behind them.
const Service& service() {
  static const Service service({{.method = "GET",
                                 .pattern = "/api/v1/health",
                                 .operation = "get",
                                 .summary = "",
                                 .handler = [](const Request&) { return done(); },
                                 .answers = {}},
                                reading("/m", [](const Request& r) { read_model_request(r.body); }),
                                reading("/s", [](const Request& r) { read_simulation_request(r.body); }),
                                reading("/c", [](const Request& r) { read_simulation_change(r.body, {}); }),
                                reading("/n", [](const Request& r) { read_step_count(r.body); }),
                                reading("/g", [](const Request& r) { read_grab(r.body); }),
                                reading("/p/{id}", [](const Request& r) { read_pose(r.body); }),
                                reading("/r", [](const Request& r) { read_report_request(r.body); }),
                                reading(
                                    "/f", [](const Request&) {}, BodyKind::file)},
                               loopback_policy(1, "t"));
  return service;
}

class SocketPair {
 public:
  SocketPair() { socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends_); }
  ~SocketPair() { ::close(ends_[1]); }
  int server() const { return ends_[0]; }  ///< closed by its connection
  int peer() const { return ends_[1]; }

 private:
  int ends_[2];
};

void check_answer(const std::string& answer) {
  if (answer.empty() || answer == "HTTP/1.1 100 Continue\r\n\r\n") return;
  const std::size_t status = answer.find("HTTP/1.1 ");
  const std::size_t end = answer.rfind("\r\n\r\n");
  if (status != 0 || end == std::string::npos) fuzz_finding("not an answer: " + answer);
  const std::size_t last = answer.rfind("HTTP/1.1 ", end);
  if (answer.compare(last + 9, 3, "500") == 0) fuzz_finding("an internal error: " + answer);
  if (answer.find("content-security-policy", last) == std::string::npos &&
      answer.find("Content-Security-Policy", last) == std::string::npos)
    fuzz_finding("an answer without the policy: " + answer);
  if (end + 4 < answer.size() && !Json::accept(answer.substr(end + 4)))
    fuzz_finding("a body that is not JSON: " + answer);
}

}  // namespace

void fuzz_http(std::string_view bytes) {
  static const ConnectionLimits limits;
  const auto now = Clock::now();
  const SocketPair sockets;
  Connection connection(Socket(sockets.server()), 2, limits, now);
  if (!bytes.empty() && ::send(sockets.peer(), bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) return;
  ::shutdown(sockets.peer(), SHUT_WR);
  // In a few reads everything has been taken, or the connection has closed.
  for (int turn = 0; turn < 8 && !connection.closed(); ++turn)
    if (connection.on_readable(service(), now))
      connection.respond(service().answer(connection.take_admission()), now);
  static std::array<char, 65536> buffer;  // a fresh one costs more than the request
  const ssize_t got = ::recv(sockets.peer(), buffer.data(), buffer.size(), 0);
  check_answer(std::string(buffer.data(), got > 0 ? static_cast<std::size_t>(got) : 0));
}

}  // namespace isochor
