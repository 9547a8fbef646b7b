#include "server/http/query.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/common/error.h"
#include "server/http/head_check.h"

namespace isochor {
namespace {

[[noreturn]] void fault(std::string_view name, const std::string& detail, std::optional<double> min = {},
                        std::optional<double> max = {}) {
  throw Error(ErrorCode::invalid_argument, "query: " + std::string(name) + " " + detail,
              "correct the query of the URL", {{"?" + std::string(name), detail, min, max}});
}

template <class T>
std::optional<T> parse(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

Fields parse_query(std::string_view query) {
  const auto decode = [](std::string_view text) {
    std::string spaced(text);
    std::replace(spaced.begin(), spaced.end(), '+', ' ');
    return percent_decode(spaced).value_or("");
  };
  Fields fields;
  query.remove_prefix(std::min<std::size_t>(query.size(), 1));
  while (!query.empty()) {
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), part.size() + 1));
    if (part.empty()) continue;
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::size_t value = std::min(equals + 1, part.size());
    fields.emplace_back(decode(part.substr(0, equals)), decode(part.substr(value)));
  }
  return fields;
}

void check_query(const Request& request, std::span<const QuerySpec> known) {
  for (const auto& [name, value] : request.query) {
    if (std::ranges::count(request.query, name, &Fields::value_type::first) > 1)
      fault(name, "stands there twice");
    if (std::ranges::find(known, name, &QuerySpec::name) != known.end()) continue;
    std::string names;
    for (const QuerySpec& one : known) names += (names.empty() ? "" : ", ") + std::string(one.name);
    fault(name, names.empty() ? "is not known here: there is none" : "is not known here; known are " + names);
  }
}

std::int64_t query_integer(const Request& request, std::string_view name, std::int64_t fallback,
                           std::int64_t min, std::int64_t max) {
  const std::string* text = request.parameter(name);
  if (!text) return fallback;
  const auto value = parse<std::int64_t>(*text);
  if (!value || *value < min || *value > max)
    fault(name, "is not an integer in range", static_cast<double>(min), static_cast<double>(max));
  return *value;
}

bool query_boolean(const Request& request, std::string_view name, bool fallback) {
  return query_choice(request, name, {"false", "true"}, fallback ? 1 : 0) == 1;
}

std::size_t query_choice(const Request& request, std::string_view name,
                         const std::vector<std::string_view>& choices, std::size_t fallback) {
  const std::string* text = request.parameter(name);
  if (!text) return fallback;
  const auto found = std::find(choices.begin(), choices.end(), *text);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  std::string names;
  for (const std::string_view choice : choices) names += (names.empty() ? "" : ", ") + std::string(choice);
  fault(name, "is not one of " + names);
}

Precision query_precision(const Request& request) {
  return query_choice(request, "encoding", {"f32", "f64"}, 0) == 1 ? Precision::f64 : Precision::f32;
}

QuerySpec precision_spec() {
  return {"encoding", R"({"enum":["f32","f64"],"default":"f32"})", "How precisely positions are written"};
}

Vec3 query_vector(const Request& request, std::string_view name) {
  const std::string* text = request.parameter(name);
  if (!text) fault(name, "is missing");
  std::string_view rest = *text;
  Vec3 value;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = parse<double>(rest.substr(0, rest.find(',')));
    const bool last = rest.find(',') == std::string_view::npos;
    if (!number || !std::isfinite(*number) || last != (axis == 2)) fault(name, "is not three numbers x,y,z");
    value[axis] = *number;
    rest.remove_prefix(last ? rest.size() : rest.find(',') + 1);
  }
  return value;
}

}  // namespace isochor
