#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/body.h"
#include "server/http/nameless_file.h"
#include "server/stream/byte_source.h"

namespace isochor {

using Fields = std::vector<std::pair<std::string, std::string>>;

/// A request that passed the guard (server/http/head_check.h, access.h): a value, and whole.
struct Request {
  std::string method;
  std::string path;      ///< still percent-encoded, without the query
  Fields query;          ///< decoded
  Fields headers;        ///< names in lower case
  Fields path_segments;  ///< decoded values of the route's {names}
  Body body;
  std::shared_ptr<const std::atomic<bool>> abandoned;  ///< set once its sender has gone; null: nobody tells

  /// First value; nullptr when absent.
  const std::string* header(std::string_view lower_case_name) const;
  const std::string* parameter(std::string_view name) const;
  const std::string& segment(std::string_view name) const;
};

struct Response;

/// An answer that is not known yet: asked again whenever something changed, and at the deadline for the last
/// time, when it must answer.
struct PendingAnswer {
  std::function<std::optional<Response>(bool deadline_passed)> poll;
  std::chrono::steady_clock::time_point deadline;
};

struct Response {
  int status = 200;
  std::string content_type;  ///< empty: application/json where there is a body
  Fields headers;
  SharedBytes body;                          ///< shared by all who ask for the same; may be null
  std::shared_ptr<const NamelessFile> file;  ///< instead of a body, a large one
  std::shared_ptr<ByteSource> stream;        ///< instead of a body: an endless one, chunked
  std::shared_ptr<PendingAnswer> pending;

  std::size_t body_size() const { return file ? file->size() : body ? body->size() : 0; }

  static Response json(std::string text, int status = 200);
  static Response empty(int status = 204);
};

}  // namespace isochor
