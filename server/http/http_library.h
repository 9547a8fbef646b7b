#pragma once
#include <string>

#include "server/http/message.h"

namespace isochor {

/// cpp-httplib behind a door: it formats the heads of answers, in memory. It never sees what a peer sent: its
/// limits are missing there (0.11: unbounded chunked bodies and headers, Range amplification, Brotli at the
/// highest quality), or silent (of a request with a longer line it loses all headers and the query).

/// The response's head, Connection: close included.
std::string format_head(const Response& response);

}  // namespace isochor
