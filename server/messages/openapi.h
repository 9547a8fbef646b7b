#pragma once
#include <span>
#include <string>

#include "server/http/router.h"

namespace isochor {

/// OpenAPI 3.1 of the table of routes, with the schemas of what they take and answer.
std::string encode_openapi(std::span<const Route> routes);

/// The same for readers: one HTML page without scripts.
std::string encode_api_page(std::span<const Route> routes);

}  // namespace isochor
