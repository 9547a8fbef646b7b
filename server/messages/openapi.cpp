#include "server/messages/openapi.h"

#include <fmt/format.h>

#include "server/build_info.h"
#include "server/messages/json.h"
#include "server/messages/problem_messages.h"
#include "server/messages/schemas.h"

namespace isochor {
namespace {

Json reference(std::string_view name) {
  return {{"$ref", "#/components/schemas/" + std::string(name)}};
}

std::vector<std::string> path_names(std::string_view pattern) {
  std::vector<std::string> names;
  for (std::size_t at = pattern.find('{'); at != std::string_view::npos; at = pattern.find('{', at + 1))
    names.emplace_back(pattern.substr(at + 1, pattern.find('}', at) - at - 1));
  return names;
}

Json parameters_of(const Route& route) {
  Json parameters = Json::array();
  for (const std::string& name : path_names(route.pattern))
    parameters.push_back(
        {{"name", name}, {"in", "path"}, {"required", true}, {"schema", {{"type", "string"}}}});
  for (const QuerySpec& query : route.query)
    parameters.push_back({{"name", query.name},
                          {"in", "query"},
                          {"description", query.meaning},
                          {"schema", Json::parse(query.schema)}});
  return parameters;
}

Json body_of(const Route& route) {
  const bool json = route.body == BodyKind::json;
  Json media{
      {"schema", json ? reference(route.body_schema) : Json{{"type", "string"}, {"format", "binary"}}}};
  return {{"required", !route.body_optional},
          {"content", {{json ? "application/json" : "application/octet-stream", std::move(media)}}}};
}

Json answers_of(const Route& route) {
  Json responses = Json::object();
  for (const AnswerSpec& answer : route.answers) {
    Json& response = responses[std::to_string(answer.status)];
    response["description"] = status_title(answer.status);
    if (answer.schema.empty() && answer.media_type == "application/json") continue;
    response["content"][std::string(answer.media_type)] =
        answer.schema.empty() ? Json::object() : Json{{"schema", reference(answer.schema)}};
  }
  responses["default"] = {{"description", "What went wrong, and what to do next"},
                          {"content", {{"application/problem+json", {{"schema", reference("Problem")}}}}}};
  return responses;
}

Json operation_of(const Route& route) {
  Json operation{{"operationId", route.operation}, {"summary", route.summary}};
  if (Json parameters = parameters_of(route); !parameters.empty())
    operation["parameters"] = std::move(parameters);
  if (route.body != BodyKind::none) operation["requestBody"] = body_of(route);
  operation["responses"] = answers_of(route);
  if (route.method != "GET") operation["security"] = Json::array({{{"token", Json::array()}}});
  return operation;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

std::string row(const Route& route) {
  std::string details;
  for (const QuerySpec& query : route.query)
    details += fmt::format("<br><code>?{}</code> {}", query.name, escape(query.meaning));
  if (!route.body_schema.empty()) details += fmt::format("<br>takes {}", route.body_schema);
  for (const AnswerSpec& answer : route.answers)
    details += fmt::format("<br>{} {} {}", answer.status, answer.schema,
                           answer.media_type == "application/json" ? "" : escape(answer.media_type));
  return fmt::format("<tr><td><code>{} {}</code></td><td>{}{}</td></tr>\n", route.method,
                     escape(route.pattern), escape(route.summary), details);
}

}  // namespace

std::string encode_openapi(std::span<const Route> routes) {
  Json paths = Json::object();
  for (const Route& route : routes)
    paths[std::string(route.pattern)][lower(route.method)] = operation_of(route);
  return to_text({{"openapi", "3.1.0"},
                  {"info", {{"title", "Isochor"}, {"version", build_info().version}}},
                  {"paths", std::move(paths)},
                  {"components",
                   {{"schemas", Json::parse(api_schemas())},
                    {"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}}});
}

std::string encode_api_page(std::span<const Route> routes) {
  std::string rows;
  for (const Route& route : routes) rows += row(route);
  return "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Isochor API</title>\n"
         "<link rel=\"stylesheet\" href=\"/styles/theme.css\">\n<h1>Isochor API</h1>\n"
         "<p>For machines: <a href=\"/api/v1/openapi.json\">openapi.json</a>. Requests that change state "
         "send "
         "<code>Authorization: Bearer TOKEN</code>; errors are RFC 9457 problem documents.</p>\n<table>\n" +
         rows + "</table>\n</html>\n";
}

}  // namespace isochor
