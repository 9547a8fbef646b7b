#pragma once
#include <string>
#include <variant>
#include <vector>

#include "server/http/access.h"
#include "server/http/message.h"
#include "server/http/router.h"

namespace isochor {

/// Bounds of bodies; what is beyond is refused before it is read.
inline constexpr std::size_t max_json_bytes = std::size_t{1} << 20, max_file_bytes = std::size_t{1} << 30;

/// A request whose head passed every check; its body is still to be read.
struct Admission {
  const Route* route = nullptr;
  Request request;
  bool expects_continue = false;
  bool head_only = false;
};

/// request → response: the guard before the handlers, and the one wrapper that turns what they throw into
/// problem documents. Has no sockets.
class Service {
 public:
  /// fallback answers GETs of what no route matches: the page's files.
  Service(std::vector<Route> routes, AccessPolicy policy,
          std::function<std::optional<Response>(const Request&)> fallback = {});

  /// All that can be judged from the head alone.
  std::variant<Admission, Response> admit(std::string_view head) const;
  /// Runs the handler. Never throws.
  Response answer(const Admission& admission) const;

  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::variant<RouteMatch, Response> route(const Head& head, const Request& request) const;

  std::vector<Route> routes_;
  AccessPolicy policy_;
  Route fallback_;
};

/// Content-Security-Policy and what else every answer carries; Cache-Control: no-store unless it is set.
void add_security_headers(Response& response);

Response problem_response(const Refusal& refusal);
Response problem_response(const Error& error);

[[noreturn]] void refuse(int status, std::string code, std::string detail, std::string hint = {});

}  // namespace isochor
