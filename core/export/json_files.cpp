#include <algorithm>

#include "core/common/error.h"
#include "core/export/writers.h"

namespace isochor {
namespace {

template <class Range, class Item>
void array(Text& text, std::string_view name, const Range& range, const Item& item) {
  text << ",\n\"" << name << "\":[";
  bool first = true;
  for (const auto& element : range) {
    if (!first) text << ',';
    first = false;
    item(element);
  }
  text << ']';
}

/// Each edge once, sorted.
std::vector<std::array<std::int32_t, 2>> edges_of(const TetMesh& mesh) {
  std::vector<std::array<std::int32_t, 2>> edges;
  edges.reserve(6 * mesh.tets.size());
  for (const Tet& tet : mesh.tets)
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b) edges.push_back({std::min(tet[a], tet[b]), std::max(tet[a], tet[b])});
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

void write_tet_json(const ExportModel& model, ExportTexts& files) {
  const TetMesh& mesh = model.mesh;
  Text& text = files.begin(".json");
  text << "{\"comment\":\"" << without_escapes(model.comment) << '"';
  array(text, "verts", mesh.positions, [&](const Vec3& p) { text << p.x() << ',' << p.y() << ',' << p.z(); });
  const auto indices = [&](const auto& tuple) { text.list(tuple, ',', 0); };
  array(text, "tetIds", mesh.tets, indices);
  array(text, "tetEdgeIds", edges_of(mesh), indices);
  array(text, "tetSurfaceTriIds", mesh.surface, indices);
  text << "}\n";
}

void write_embedding(const ExportModel& model, ExportTexts& files) {
  if (!model.embedding)
    throw Error(ErrorCode::invalid_argument, "the format \"embedding\" needs a model made from a mesh",
                "choose another format");
  const Embedding& embedding = *model.embedding;
  Text& text = files.begin(".embedding.json");
  text << "{\"comment\":\"" << without_escapes(model.comment) << "\",\n\"count\":" << embedding.tet.size();
  array(text, "tet", embedding.tet, [&](std::int32_t tet) { text << tet; });
  array(text, "vertices", embedding.tet,
        [&](std::int32_t tet) { (text << '[').list(model.mesh.tets[tet], ',', 0) << ']'; });
  array(text, "weights", embedding.weights, [&](const std::array<double, 4>& w) {
    text << '[' << w[0] << ',' << w[1] << ',' << w[2] << ',' << w[3] << ']';
  });
  text << "}\n";
}

}  // namespace isochor
