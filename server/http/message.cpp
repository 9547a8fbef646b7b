#include "server/http/message.h"

#include "core/common/error.h"

namespace isochor {
namespace {

const std::string* find(const Fields& fields, std::string_view name) {
  for (const auto& [key, value] : fields)
    if (key == name) return &value;
  return nullptr;
}

}  // namespace

const std::string* Request::header(std::string_view lower_case_name) const {
  return find(headers, lower_case_name);
}

const std::string* Request::parameter(std::string_view name) const {
  return find(query, name);
}

const std::string& Request::segment(std::string_view name) const {
  if (const std::string* value = find(path_segments, name)) return *value;
  throw Error(ErrorCode::internal, "the route has no segment {" + std::string(name) + "}");
}

Response Response::json(std::string text, int status) {
  Response response;
  response.status = status;
  response.body = std::make_shared<const std::string>(std::move(text));
  return response;
}

Response Response::empty(int status) {
  Response response;
  response.status = status;
  return response;
}

}  // namespace isochor
