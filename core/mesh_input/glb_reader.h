#pragma once
#include <span>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// The triangles of all meshes of a binary glTF 2.0 file, where its nodes place them. Whatever lies outside
/// the file is refused: nothing is opened. Throws cannot_read, over_budget.
TriangleSoup read_glb(std::span<const char> bytes);

}  // namespace isochor
