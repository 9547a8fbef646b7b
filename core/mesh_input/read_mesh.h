#pragma once
#include <filesystem>
#include <span>
#include <string_view>

#include "core/common/progress.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

enum class MeshFormat { obj, stl, ply, off, glb };

/// From a file name's extension (any case). Throws unsupported_format.
MeshFormat mesh_format(const std::filesystem::path& path);

/// Polygons are triangulated. Throws cannot_read (with the line or byte) for a missing, truncated or
/// malformed file, an index out of range, a NaN or infinite coordinate; empty_result when there is no
/// triangle.
TriangleSoup read_mesh(const std::filesystem::path& path, Progress& progress);
TriangleSoup read_mesh(std::span<const char> bytes, MeshFormat format, Progress& progress);

}  // namespace isochor
