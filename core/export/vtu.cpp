#include "core/export/vtu.h"

#include "core/export/writers.h"
#include "core/quality/quality.h"

namespace isochor {
namespace {

template <class Value>
void data_array(Text& text, std::string_view attributes, std::size_t count, const Value& value) {
  text << "<DataArray " << attributes << " format=\"ascii\">\n";
  for (std::size_t i = 0; i < count; ++i) {
    value(i);
    text << '\n';
  }
  text << "</DataArray>\n";
}

void cell_data(Text& text, const TetMesh& mesh, std::span<const Vec3> positions) {
  const std::size_t count = mesh.tets.size();
  const TetQuality quality = tet_quality(positions, mesh.tets);
  text << "<CellData>\n";
  data_array(text, "type=\"Int64\" Name=\"cell\"", count, [&](auto t) { text << t / 5; });
  data_array(text, "type=\"Int32\" Name=\"cell_coordinates\" NumberOfComponents=\"3\"", count,
             [&](auto t) { text << mesh.cells[t / 5].coord; });
  data_array(text, "type=\"Float64\" Name=\"volume\"", count, [&](auto t) {
    const Tet& v = mesh.tets[t];
    text << tet_volume(positions[v[0]], positions[v[1]], positions[v[2]], positions[v[3]]);
  });
  data_array(text, "type=\"Float32\" Name=\"min_dihedral_deg\"", count,
             [&](auto t) { text << quality.min_dihedral_deg[t]; });
  data_array(text, "type=\"Float32\" Name=\"scaled_jacobian\"", count,
             [&](auto t) { text << quality.scaled_jacobian[t]; });
  text << "</CellData>\n";
}

/// XML comments must not hold two hyphens in a row, nor end with one.
std::string comment_text(std::string text) {
  for (std::size_t i = 1; i < text.size(); ++i)
    if (text[i] == '-' && text[i - 1] == '-') text[i] = ' ';
  return text;
}

}  // namespace

void write_vtu_text(Text& text, const TetMesh& mesh, std::span<const Vec3> positions,
                    const std::string& comment) {
  const std::size_t count = mesh.tets.size();
  text << "<?xml version=\"1.0\"?>\n<!-- " << comment_text(comment) << " -->\n"
       << "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
          "header_type=\"UInt64\">\n<UnstructuredGrid>\n"
       << "<Piece NumberOfPoints=\"" << positions.size() << "\" NumberOfCells=\"" << count << "\">\n";
  text << "<Points>\n";
  data_array(text, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", positions.size(),
             [&](auto i) { text << positions[i]; });
  text << "</Points>\n<Cells>\n";
  data_array(text, "type=\"Int64\" Name=\"connectivity\"", count, [&](auto t) { text << mesh.tets[t]; });
  data_array(text, "type=\"Int64\" Name=\"offsets\"", count, [&](auto t) { text << 4 * (t + 1); });
  data_array(text, "type=\"UInt8\" Name=\"types\"", count, [&](auto) { text << 10; });
  text << "</Cells>\n";
  cell_data(text, mesh, positions);
  text << "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

void write_vtu(const ExportModel& model, ExportTexts& files) {
  write_vtu_text(files.begin(".vtu"), model.mesh, model.mesh.positions, model.comment);
}

}  // namespace isochor
