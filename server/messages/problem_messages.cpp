#include "server/messages/problem_messages.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/problem.h"

namespace isochor {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array titles{
    std::pair{200, "OK"},
    std::pair{201, "Created"},
    std::pair{202, "Accepted"},
    std::pair{204, "No Content"},
    std::pair{304, "Not Modified"},
    std::pair{400, "Bad Request"},
    std::pair{401, "Unauthorized"},
    std::pair{403, "Forbidden"},
    std::pair{404, "Not Found"},
    std::pair{405, "Method Not Allowed"},
    std::pair{406, "Not Acceptable"},
    std::pair{408, "Request Timeout"},
    std::pair{409, "Conflict"},
    std::pair{410, "Gone"},
    std::pair{411, "Length Required"},
    std::pair{413, "Content Too Large"},
    std::pair{414, "URI Too Long"},
    std::pair{415, "Unsupported Media Type"},
    std::pair{416, "Range Not Satisfiable"},
    std::pair{417, "Expectation Failed"},
    std::pair{421, "Misdirected Request"},
    std::pair{422, "Unprocessable Content"},
    std::pair{429, "Too Many Requests"},
    std::pair{431, "Request Header Fields Too Large"},
    std::pair{500, "Internal Server Error"},
    std::pair{501, "Not Implemented"},
    std::pair{503, "Service Unavailable"},
    std::pair{505, "HTTP Version Not Supported"},
    std::pair{507, "Insufficient Storage"},
};

/// Text from outside may hold any bytes: replace what is not UTF-8 instead of throwing.
std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Beginning and end of a text that repeats what was sent, megabytes if need be.
std::string shortened(std::string_view text) {
  constexpr std::size_t longest = 2000, kept = 900;
  if (text.size() <= longest) return std::string(text);
  return std::string(text.substr(0, kept)) + " … " + std::string(text.substr(text.size() - kept));
}

Json problem(int status, std::string_view code, std::string_view detail, std::string_view hint) {
  Json json{{"type", "about:blank"},
            {"title", status_title(status)},
            {"status", status},
            {"detail", shortened(detail)},
            {"code", code}};
  if (!hint.empty()) json["hint"] = shortened(hint);
  return json;
}

}  // namespace

std::string encode_problem(const Error& error) {
  const ProblemMapping mapping = problem_mapping(error.code());
  Json json = problem(mapping.http_status, mapping.code, error.what(), error.hint());
  for (const ErrorDetail& detail : error.details()) {
    Json entry{{"pointer", shortened(detail.pointer)}, {"detail", shortened(detail.detail)}};
    if (detail.min) entry["min"] = *detail.min;
    if (detail.max) entry["max"] = *detail.max;
    json["errors"].push_back(std::move(entry));
  }
  return dump(json);
}

std::string encode_problem(const Refusal& refusal) {
  return dump(problem(refusal.status, refusal.code, refusal.detail, refusal.hint));
}

std::string_view status_title(int status) {
  for (const auto& [code, title] : titles)
    if (code == status) return title;
  return "Error";
}

}  // namespace isochor
