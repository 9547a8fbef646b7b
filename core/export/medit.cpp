#include "core/export/text.h"
#include "core/export/writers.h"

namespace isochor {

// Version 2 says double precision. libigl wants Dimension, Vertices, Triangles, Tetrahedra in this order.
std::vector<ExportFile> write_medit(const ExportModel& model) {
  const TetMesh& mesh = model.mesh;
  Text text;
  text << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.positions.size() << '\n';
  for (const Vec3& position : mesh.positions) text << position << " 0\n";
  text << "Triangles\n" << mesh.surface.size() << '\n';
  for (const Triangle& triangle : mesh.surface) text.list(triangle, ' ', 1) << " 0\n";
  text << "Tetrahedra\n" << mesh.tets.size() << '\n';
  for (const Tet& tet : mesh.tets) text.list(tet, ' ', 1) << " 0\n";
  text << "End\n# " << model.comment << '\n';
  return {{".mesh", text.take()}};
}

}  // namespace isochor
