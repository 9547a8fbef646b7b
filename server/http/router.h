#pragma once
#include <functional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "server/http/message.h"
#include "server/messages/problem_messages.h"

namespace isochor {

enum class BodyKind { none, json, file };

struct QuerySpec {
  std::string_view name, schema, meaning;  ///< schema: JSON Schema as text
};
struct AnswerSpec {
  int status;
  std::string_view schema;  ///< name in the OpenAPI components; empty: no body, or not JSON
  std::string_view media_type = "application/json";
};

/// One row of the table of routes: dispatch, 404 and 405, and /openapi.json all come from it.
struct Route {
  std::string_view method, pattern;     ///< "/models/{id}"
  std::string_view operation, summary;  ///< OpenAPI's operationId and summary
  std::function<Response(const Request&)> handler;
  std::vector<AnswerSpec> answers;
  BodyKind body = BodyKind::none;
  std::string_view body_schema = {};
  std::vector<QuerySpec> query = {};
  bool body_optional = false;
  bool immediate = false;  ///< answered at once by the front's thread: must not take a millisecond
  bool open = false;       ///< readable without a token also where reading needs one
};

struct RouteMatch {
  const Route* route = nullptr;
  Fields segments;
};

/// 404 for an unknown path, 405 for a known one with another method; allowed then lists the methods.
struct NoRoute {
  Refusal refusal;
  std::string allowed;
};
/// HEAD finds the GET route.
std::variant<RouteMatch, NoRoute> find_route(std::span<const Route> routes, std::string_view method,
                                             std::string_view path);

}  // namespace isochor
