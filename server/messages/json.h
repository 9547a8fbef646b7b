#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "core/common/types.h"

namespace isochor {

/// Members keep the order in which they were added.
using Json = nlohmann::ordered_json;

/// Text from outside may hold any bytes: what is not UTF-8 is replaced instead of throwing. Numbers that are
/// not finite become null. indent −1 writes one line.
inline std::string to_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

inline Json vec3_json(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace isochor
