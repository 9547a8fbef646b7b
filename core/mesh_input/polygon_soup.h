#pragma once
#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh_input/check.h"
#include "core/mesh_input/read_mesh.h"

namespace isochor {

/// Corners are vertex indices; triangles and quads need no memory of their own.
using Polygon = boost::container::small_vector<std::int32_t, 4>;

struct PolygonSoup {
  std::vector<Vec3> positions;
  std::vector<Polygon> polygons;
};

/// Reads a checked mesh with CGAL's polygon soup readers.
PolygonSoup read_with_cgal(const CheckedMesh& mesh, MeshFormat format, Progress& progress);

/// Every polygon of n corners becomes n−2 triangles: a fan when it is convex in its own plane, ears else.
TriangleSoup triangulate(PolygonSoup soup, Progress& progress);

}  // namespace isochor
