#include "core/export/writers.h"

namespace isochor {

// Version 2 says double precision. libigl wants Dimension, Vertices, Triangles, Tetrahedra in this order.
void write_medit(const ExportModel& model, ExportTexts& files) {
  const TetMesh& mesh = model.mesh;
  Text& text = files.begin(".mesh");
  text << "MeshVersionFormatted 2\nDimension 3\nVertices\n" << mesh.positions.size() << '\n';
  for (const Vec3& position : mesh.positions) text << position << " 0\n";
  text << "Triangles\n" << mesh.surface.size() << '\n';
  for (const Triangle& triangle : mesh.surface) text.list(triangle, ' ', 1) << " 0\n";
  text << "Tetrahedra\n" << mesh.tets.size() << '\n';
  for (const Tet& tet : mesh.tets) text.list(tet, ' ', 1) << " 0\n";
  text << "End\n# " << model.comment << '\n';
}

}  // namespace isochor
