#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/common/types.h"
#include "server/http/message.h"
#include "server/http/router.h"
#include "server/messages/api_messages.h"

namespace isochor {

/// What stands behind the '?' of a target, decoded. Its escapes have been checked.
Fields parse_query(std::string_view query);

/// Throws invalid_argument where a name stands in the query that the route does not know, or stands there
/// twice.
void check_query(const Request& request, std::span<const QuerySpec> known);

/// Values of a request's query, checked; a faulty one throws invalid_argument with the pointer "?name".
std::int64_t query_integer(const Request& request, std::string_view name, std::int64_t fallback,
                           std::int64_t min, std::int64_t max);
bool query_boolean(const Request& request, std::string_view name, bool fallback);
/// The index among the choices.
std::size_t query_choice(const Request& request, std::string_view name,
                         const std::vector<std::string_view>& choices, std::size_t fallback);
/// Of positions, by "encoding": f32 or f64.
Precision query_precision(const Request& request);
QuerySpec precision_spec();
Vec3 query_vector(const Request& request, std::string_view name);

}  // namespace isochor
