#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace isochor {

/// What a check hands to the library's reader: the same mesh in the plain dialect of its format, in which
/// nothing is left that the reader could stumble over. Memory grows with the bytes that are there, never with
/// a count that a header claims.
struct CheckedMesh {
  std::string plain;
  std::int64_t vertices = 0, polygons = 0;  ///< that the reader must find; an STL's vertices are merged later
};

/// Each throws cannot_read with the line or byte: truncation, counts that lie, coordinates that are not
/// finite, indices out of range.
CheckedMesh check_obj(std::span<const char> bytes);
CheckedMesh check_off(std::span<const char> bytes);
CheckedMesh check_stl(std::span<const char> bytes);
CheckedMesh check_ply(std::span<const char> bytes);

/// where is "line 7" or "byte 99"; first is the index that the format starts counting at.
[[noreturn]] void throw_bad_index(const std::string& where, std::int64_t index, std::int64_t first,
                                  std::int64_t vertices);

/// Vertex indices are 32 bits.
inline constexpr std::int64_t largest_vertex_count = (std::int64_t{1} << 31) - 1;

}  // namespace isochor
