#include "core/export/text.h"
#include "core/export/writers.h"

namespace isochor {

// Indices from 0, since Bullet uses them as they stand; the counts come first, since it reads no comment.
std::vector<ExportFile> write_tetgen(const ExportModel& model) {
  const TetMesh& mesh = model.mesh;
  Text node, ele, face;
  node << mesh.positions.size() << " 3 0 0\n";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) node << i << ' ' << mesh.positions[i] << '\n';
  ele << mesh.tets.size() << " 4 0\n";
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) ele << t << ' ' << mesh.tets[t] << '\n';
  face << mesh.surface.size() << " 0\n";
  for (std::size_t f = 0; f < mesh.surface.size(); ++f) face << f << ' ' << mesh.surface[f] << '\n';
  for (Text* text : {&node, &ele, &face}) *text << "# " << model.comment << '\n';
  return {{".node", node.take()}, {".ele", ele.take()}, {".face", face.take()}};
}

}  // namespace isochor
