#pragma once
#include <cstdint>

#include "core/scene/scene.h"

namespace isochor {

/// Of a body's cell while the body is built and while it steps, with every solver's arrays.
inline constexpr std::int64_t bytes_a_cell = 3400;

/// What compile() is going to take for the deformable bodies; a mesh that is still to be made counts nothing.
std::int64_t estimated_bytes(const Scene& scene);

}  // namespace isochor
