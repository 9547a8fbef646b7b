#include "core/export/writers.h"

namespace isochor {

// The comment stands last: some readers expect $Nodes right after the header.
void write_msh2(const ExportModel& model, ExportTexts& files) {
  const TetMesh& mesh = model.mesh;
  Text& text = files.begin(".msh");
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << mesh.positions.size() << '\n';
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) text << i + 1 << ' ' << mesh.positions[i] << '\n';
  text << "$EndNodes\n$Elements\n" << mesh.tets.size() << '\n';
  // Type 4 is the tetrahedron; two tags: physical and elementary entity, both 1.
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    (text << t + 1 << " 4 2 1 1 ").list(mesh.tets[t], ' ', 1) << '\n';
  text << "$EndElements\n$Comments\n" << model.comment << "\n$EndComments\n";
}

}  // namespace isochor
