#include "core/export/writers.h"

namespace isochor {

void write_vtk(const ExportModel& model, ExportTexts& files) {
  const TetMesh& mesh = model.mesh;
  constexpr std::size_t title_limit = 255;  // the format's, the line end included
  std::string title = model.comment.substr(0, title_limit - 1);
  Text& text = files.begin(".vtk");
  text << "# vtk DataFile Version 3.0\n" << title << "\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  text << "POINTS " << mesh.positions.size() << " double\n";
  for (const Vec3& position : mesh.positions) text << position << '\n';
  text << "CELLS " << mesh.tets.size() << ' ' << 5 * mesh.tets.size() << '\n';
  for (const Tet& tet : mesh.tets) text << "4 " << tet << '\n';
  text << "CELL_TYPES " << mesh.tets.size() << '\n';
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) text << "10\n";
  text << "CELL_DATA " << mesh.tets.size() << "\nSCALARS cell int 1\nLOOKUP_TABLE default\n";
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) text << t / 5 << '\n';
}

}  // namespace isochor
