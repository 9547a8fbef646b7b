#pragma once
#include <cstddef>
#include <functional>
#include <string_view>

namespace isochor {

/// Takes a text a piece at a time, so that a large one never stands in memory as a whole.
using TextSink = std::function<void(std::string_view)>;

/// How long a piece gets before it is passed on.
inline constexpr std::size_t text_piece_bytes = 64 * 1024;

}  // namespace isochor
