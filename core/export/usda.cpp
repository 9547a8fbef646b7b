#include "core/export/writers.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {
namespace {

/// `name = [item, item, …]`, ten items a line.
template <class Count, class Item>
void array(Text& text, std::string_view name, Count count, const Item& item) {
  text << "        " << name << " = [";
  for (Count i = 0; i < count; ++i) {
    if (i > 0) text << (i % 10 == 0 ? ",\n            " : ", ");
    item(i);
  }
  text << "]\n";
}

void point(Text& text, const Vec3& p) {
  text << '(' << p.x() << ", " << p.y() << ", " << p.z() << ')';
}

template <std::size_t Count>
void tuple(Text& text, const std::array<std::int32_t, Count>& indices) {
  text << '(';
  for (std::size_t i = 0; i < Count; ++i) text << (i > 0 ? ", " : "") << indices[i];
  text << ')';
}

void extent(Text& text, const TetMesh& mesh) {
  Box box;
  for (const Vec3& position : mesh.positions) box.extend(position);
  array(text, "float3[] extent", 2, [&](int i) { point(text, i == 0 ? box.min : box.max); });
}

// A rightHanded tetrahedron has its outward faces [123] [032] [013] [021], which is our winding.
void tet_mesh(Text& text, const TetMesh& mesh) {
  text << "    def TetMesh \"tets\"\n    {\n        uniform token orientation = \"rightHanded\"\n";
  extent(text, mesh);
  array(text, "point3f[] points", mesh.positions.size(), [&](auto i) { point(text, mesh.positions[i]); });
  array(text, "int4[] tetVertexIndices", mesh.tets.size(), [&](auto i) { tuple(text, mesh.tets[i]); });
  array(text, "int3[] surfaceFaceVertexIndices", mesh.surface.size(),
        [&](auto i) { tuple(text, mesh.surface[i]); });
  text << "    }\n";
}

/// Renderers that know no TetMesh draw this one.
void companion_mesh(Text& text, const TetMesh& mesh) {
  const BoundarySurface surface = boundary_surface(mesh);
  text << "\n    def Mesh \"surface\"\n    {\n        uniform token orientation = \"rightHanded\"\n"
       << "        uniform token subdivisionScheme = \"none\"\n";
  extent(text, mesh);
  array(text, "point3f[] points", surface.vertex.size(),
        [&](auto i) { point(text, mesh.positions[surface.vertex[i]]); });
  array(text, "int[] faceVertexCounts", surface.triangles.size(), [&](auto) { text << 3; });
  array(text, "int[] faceVertexIndices", 3 * surface.triangles.size(),
        [&](auto i) { text << surface.triangles[i / 3][i % 3]; });
  text << "    }\n";
}

}  // namespace

void write_usda(const ExportModel& model, ExportTexts& files) {
  Text& text = files.begin(".usda");
  text << "#usda 1.0\n# " << model.comment
       << "\n(\n    defaultPrim = \"model\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
       << "def Xform \"model\"\n{\n";
  tet_mesh(text, model.mesh);
  companion_mesh(text, model.mesh);
  text << "}\n";
}

}  // namespace isochor
