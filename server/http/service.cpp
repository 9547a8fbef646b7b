#include "server/http/service.h"

#include <algorithm>
#include <exception>
#include <new>

#include "server/http/http_library.h"
#include "server/http/query.h"
#include "server/messages/request_messages.h"
#include "server/problem.h"
#include "server/store/catalog.h"

namespace isochor {
namespace {

constexpr std::string_view content_security_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' blob:; "
    "worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

constexpr std::size_t max_kept_value = 1024;

bool reads(const Head& head) {
  return head.method == "GET" || head.method == "HEAD";
}

/// Whatever its parameters; names of media types have no case (RFC 9110, 8.3.1).
bool is_json(const std::string_view* content_type) {
  if (!content_type) return false;
  std::string name = lower_case(content_type->substr(0, content_type->find(';')));
  name.erase(name.find_last_not_of(" \t") + 1);
  return name == "application/json";
}

std::optional<Refusal> check_body(const Head& head, const Route& route) {
  if (route.body == BodyKind::none) {
    if (head.content_length > 0) return Refusal{413, "too_large", "this path takes no body", ""};
    return std::nullopt;
  }
  if (!head.declares_length && !route.body_optional)
    return Refusal{411, "length_required", "a body is needed, and its Content-Length", ""};
  const std::size_t limit = route.body == BodyKind::json ? max_json_bytes : max_file_bytes;
  if (head.content_length > limit)
    return Refusal{413, "too_large", "the body exceeds " + std::to_string(limit >> 20) + " MiB", ""};
  if (route.body == BodyKind::json && head.content_length > 0 && !is_json(head.field("content-type")))
    return Refusal{415, "unsupported_media_type", "the body must be application/json", ""};
  return std::nullopt;
}

bool matches_etag(const Request& request, const Response& response) {
  const std::string* known = request.header("if-none-match");
  if (!known || response.status != 200 || !(request.method == "GET" || request.method == "HEAD"))
    return false;
  if (*known == "*") return true;
  for (const auto& [name, value] : response.headers)
    if (name == "ETag") return known->find(value) != std::string::npos;
  return false;
}

Refusal missing_refusal(const Missing& missing) {
  const std::string name = missing.kind + " '" + missing.id + "'";
  if (!missing.evicted) return {404, "not_found", "there is no " + name, "list what there is"};
  return {410, "gone", name + " was deleted, or gave way to newer ones when memory ran out", "make it again"};
}

/// What handlers throw becomes a problem document.
template <class Produce>
std::optional<Response> with_problems(const Produce& produce) try {
  return produce();
} catch (const RefusalException& exception) {
  return problem_response(exception.refusal);
} catch (const Missing& missing) {
  return problem_response(missing_refusal(missing));
} catch (const SyntaxError& error) {
  return problem_response(Refusal{400, "syntax", error.what(), error.hint()});
} catch (const std::bad_alloc&) {
  return problem_response(Refusal{503, "out_of_memory", "the server is out of memory",
                                  "delete models or simulations, or ask for a smaller one"});
} catch (const std::exception&) {
  return problem_response(current_error());
}

/// The last resort needs no memory.
template <class Produce>
std::optional<Response> catching(const Produce& produce) try {
  return with_problems(produce);
} catch (const std::bad_alloc&) {
  return Response::empty(503);
}

}  // namespace

void add_security_headers(Response& response) {
  response.headers.emplace_back("Content-Security-Policy", content_security_policy);
  response.headers.emplace_back("X-Content-Type-Options", "nosniff");
  response.headers.emplace_back("Referrer-Policy", "no-referrer");
  response.headers.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
  for (const auto& [name, value] : response.headers)
    if (name == "Cache-Control") return;
  response.headers.emplace_back("Cache-Control", "no-store");
}

void refuse(int status, std::string code, std::string detail, std::string hint) {
  throw RefusalException{{status, std::move(code), std::move(detail), std::move(hint)}};
}

Response problem_response(const Refusal& refusal) {
  Response response = Response::json(encode_problem(refusal), refusal.status);
  response.content_type = "application/problem+json";
  if (refusal.status == 503 || refusal.status == 429) response.headers.emplace_back("Retry-After", "1");
  if (refusal.status == 401) response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

Response problem_response(const Error& error) {
  Response response = Response::json(encode_problem(error), problem_mapping(error.code()).http_status);
  response.content_type = "application/problem+json";
  return response;
}

Service::Service(std::vector<Route> routes, AccessPolicy policy,
                 std::function<std::optional<Response>(const Request&)> fallback)
    : routes_(std::move(routes)), policy_(std::move(policy)) {
  fallback_.immediate = fallback_.open = true;
  fallback_.handler = [fallback = std::move(fallback)](const Request& request) {
    if (auto found = fallback ? fallback(request) : std::nullopt) return std::move(*found);
    refuse(404, "not_found", "nothing is served at this path", "GET /api/v1/docs lists what there is");
  };
}

std::variant<RouteMatch, Response> Service::route(const Head& head, const Request& request) const {
  auto found = find_route(routes_, head.method, request.path);
  if (auto* match = std::get_if<RouteMatch>(&found)) return std::move(*match);
  const std::string& allowed = std::get<NoRoute>(found).allowed;
  if (allowed.empty() && reads(head)) return RouteMatch{&fallback_, {}};
  Response response = problem_response(std::get<NoRoute>(found).refusal);
  if (!allowed.empty()) response.headers.emplace_back("Allow", allowed);
  return response;
}

std::variant<Admission, Response> Service::admit(std::string_view text) const {
  auto checked = check_head(text);
  if (const auto* refusal = std::get_if<Refusal>(&checked)) return problem_response(*refusal);
  Head& head = std::get<Head>(checked);
  if (const auto refusal = check_origin(head, policy_)) return problem_response(*refusal);

  Admission admission;
  const std::size_t path_length = std::min(head.target.find('?'), head.target.size());
  admission.request.method = head.method;
  admission.request.path = head.target.substr(0, path_length);
  admission.request.query = parse_query(std::string_view(head.target).substr(path_length));
  auto routed = route(head, admission.request);
  if (auto* response = std::get_if<Response>(&routed)) return std::move(*response);
  auto& match = std::get<RouteMatch>(routed);
  if (!reads(head) || (policy_.token_for_reading && !match.route->open))
    if (const auto refusal = check_token(head, policy_)) return problem_response(*refusal);
  if (const auto refusal = check_body(head, *match.route)) return problem_response(*refusal);

  admission.route = match.route;
  admission.request.path_segments = std::move(match.segments);
  admission.request.body = Body(head.content_length);
  admission.expects_continue = head.expects_continue && head.content_length > 0;
  admission.head_only = head.method == "HEAD";
  for (auto& [name, value] : head.fields)  // what is longer is nothing that a route reads
    if (value.size() <= max_kept_value) admission.request.headers.emplace_back(std::move(name), value);
  return admission;
}

Response Service::answer(const Admission& admission) const {
  const Request& request = admission.request;
  Response response = *catching([&] {
    if (admission.route != &fallback_) check_query(request, admission.route->query);
    return std::optional(admission.route->handler(request));
  });
  // Elsewhere browsers ignore it, and warn.
  if (has_trustworthy_origin(request))
    response.headers.emplace_back("Cross-Origin-Opener-Policy", "same-origin");
  if (matches_etag(request, response)) {
    response.status = 304;
    response.body = nullptr;
    response.file = nullptr;
  }
  if (response.pending)
    response.pending->poll = [poll = std::move(response.pending->poll)](bool deadline_passed) {
      return catching([&] { return poll(deadline_passed); });
    };
  return response;
}

}  // namespace isochor
