#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// A kind of defect, how often it occurs and where: the positions of the first few, for the page to fly to.
struct Defect {
  std::string_view name;  ///< e.g. "open_edges"; the names are listed in inspect.cpp
  std::int64_t count = 0;
  std::vector<Vec3> locations;  ///< at most 64
};

/// Facts about a soup. Defects never refuse it.
struct MeshReport {
  std::int64_t vertices = 0, triangles = 0, components = 0;
  Box bounds;
  double area = 0.0;
  bool closed = false;  ///< no open and no non-manifold edge, consistently oriented
  /// Along every edge as many triangles run one way as the other, so that a winding number tells inside from
  /// outside: closed soups and solids that share faces or edges, but no leaves of two equal triangles.
  bool winds = false;
  double volume = 0.0;  ///< enclosed signed volume; meaningful when closed
  std::vector<Defect> defects;
};

/// Whether there are defects whose name begins so.
bool has(const MeshReport& report, std::string_view defect);

MeshReport inspect(const TriangleSoup& soup);

}  // namespace isochor
