#pragma once
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace isochor {

/// cpp-httplib behind a door: it parses and formats heads, in memory. It never sees a socket, a body, a range
/// or an Accept-Encoding, which is where its limits are missing (RELIABILITY of 0.11: unbounded chunked
/// bodies and headers, Range amplification, Brotli at the highest quality).
Request parse_request(std::string_view checked_head);

/// The response's head, Connection: close included.
std::string format_head(const Response& response);

}  // namespace isochor
