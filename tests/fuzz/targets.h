#pragma once
#include <span>
#include <string>
#include <string_view>

namespace isochor {

/// Feeds bytes to a reader: obj, stl, ply, off, glb, scene, params, or http: a connection to the front, whose
/// routes read the bodies of the API. The reader may refuse them with an
/// Error of the kinds that a caller can act on; anything else that happens is a finding, and aborts.
void fuzz_reader(std::string_view reader, std::span<const char> bytes);

[[noreturn]] void fuzz_finding(const std::string& what);
void fuzz_http(std::string_view bytes);

}  // namespace isochor
