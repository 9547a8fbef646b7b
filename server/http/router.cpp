#include "server/http/router.h"

#include "server/http/head_check.h"

namespace isochor {
namespace {

std::string_view take_segment(std::string_view& path) {
  path.remove_prefix(1);
  const std::string_view segment = path.substr(0, path.find('/'));
  path.remove_prefix(segment.size());
  return segment;
}

/// Segments are compared before they are decoded, so an encoded slash never becomes a separator.
std::optional<Fields> match(std::string_view pattern, std::string_view path) {
  Fields segments;
  while (pattern.starts_with('/') && path.starts_with('/')) {
    const std::string_view wanted = take_segment(pattern), given = take_segment(path);
    if (wanted.starts_with('{')) {
      const auto decoded = percent_decode(given);
      if (!decoded || decoded->empty()) return std::nullopt;
      segments.emplace_back(wanted.substr(1, wanted.size() - 2), *decoded);
    } else if (wanted != given) {
      return std::nullopt;
    }
  }
  if (!pattern.empty() || !path.empty()) return std::nullopt;
  return segments;
}

}  // namespace

std::variant<RouteMatch, NoRoute> find_route(std::span<const Route> routes, std::string_view method,
                                             std::string_view path) {
  std::string allowed;
  for (const Route& route : routes) {
    auto segments = match(route.pattern, path);
    if (!segments) continue;
    if (route.method == method || (method == "HEAD" && route.method == "GET"))
      return RouteMatch{&route, std::move(*segments)};
    allowed += (allowed.empty() ? "" : ", ") + std::string(route.method);
    if (route.method == "GET") allowed += ", HEAD";
  }
  if (allowed.empty())
    return NoRoute{
        {404, "not_found", "nothing is served at this path", "GET /api/v1/docs lists what there is"}, ""};
  return NoRoute{{405, "method_not_allowed", "this path takes " + allowed, ""}, allowed};
}

}  // namespace isochor
