#pragma once
#include <ostream>

#include "core/collision/shape.h"

namespace isochor {

/// For the names of tests, in the type's namespace, where GoogleTest looks for it.
inline void PrintTo(ShapeType type, std::ostream* out) {
  constexpr const char* names[] = {"plane", "sphere", "box", "capsule", "mesh"};
  *out << names[static_cast<int>(type)];
}

}  // namespace isochor
