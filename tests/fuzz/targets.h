#pragma once
#include <span>
#include <string_view>

namespace isochor {

/// Feeds bytes to a reader: obj, stl, ply, off, glb, scene or params. The reader may refuse them with an
/// Error of the kinds that a caller can act on; anything else that happens is a finding, and aborts.
void fuzz_reader(std::string_view reader, std::span<const char> bytes);

}  // namespace isochor
