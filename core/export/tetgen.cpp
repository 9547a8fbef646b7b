#include "core/export/writers.h"

namespace isochor {

// Indices from 0, since Bullet uses them as they stand; the counts come first, since it reads no comment.
void write_tetgen(const ExportModel& model, ExportTexts& files) {
  const TetMesh& mesh = model.mesh;
  const std::string comment = "# " + model.comment + '\n';
  Text& node = files.begin(".node");
  node << mesh.positions.size() << " 3 0 0\n";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) node << i << ' ' << mesh.positions[i] << '\n';
  node << comment;
  Text& ele = files.begin(".ele");
  ele << mesh.tets.size() << " 4 0\n";
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) ele << t << ' ' << mesh.tets[t] << '\n';
  ele << comment;
  Text& face = files.begin(".face");
  face << mesh.surface.size() << " 0\n";
  for (std::size_t f = 0; f < mesh.surface.size(); ++f) face << f << ' ' << mesh.surface[f] << '\n';
  face << comment;
}

}  // namespace isochor
