#pragma once
#include <string>
#include <string_view>

namespace isochor {

/// prefix + 128 bits of SHA-256: the same content has the same id, and nobody can make two contents share
/// one.
std::string content_id(std::string_view prefix, std::string_view content);

}  // namespace isochor
