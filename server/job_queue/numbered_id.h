#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace isochor {

/// Ids of a letter and a counter ("s17"); none is given out twice.

/// Whether an id was ever given out when `next` is the number to come.
bool was_issued(std::string_view id, std::int64_t next);

/// The older first: "s2" before "s10".
struct ByAge {
  bool operator()(const std::string& a, const std::string& b) const {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  }
};

}  // namespace isochor
