#include <array>
#include <bit>
#include <cstring>

#include "core/export/writers.h"

namespace isochor {

BoundarySurface boundary_surface(const TetMesh& mesh) {
  std::vector<std::int32_t> index(mesh.positions.size(), -1);
  BoundarySurface surface;
  surface.triangles = mesh.surface;
  for (Triangle& triangle : surface.triangles)
    for (std::int32_t& vertex : triangle) {
      if (index[vertex] < 0) {
        index[vertex] = static_cast<std::int32_t>(surface.vertex.size());
        surface.vertex.push_back(vertex);
      }
      vertex = index[vertex];
    }
  return surface;
}

void write_surface_obj(const ExportModel& model, ExportTexts& files) {
  const BoundarySurface surface = boundary_surface(model.mesh);
  Text& text = files.begin(".obj");
  text << "# " << model.comment << '\n';
  for (const std::int32_t vertex : surface.vertex) text << "v " << model.mesh.positions[vertex] << '\n';
  for (const Triangle& triangle : surface.triangles) (text << "f ").list(triangle, ' ', 1) << '\n';
}

void write_surface_ply(const ExportModel& model, ExportTexts& files) {
  const BoundarySurface surface = boundary_surface(model.mesh);
  Text& text = files.begin(".ply");
  text << "ply\nformat ascii 1.0\ncomment " << model.comment << "\nelement vertex " << surface.vertex.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
       << surface.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const std::int32_t vertex : surface.vertex) text << model.mesh.positions[vertex] << '\n';
  for (const Triangle& triangle : surface.triangles) text << "3 " << triangle << '\n';
}

void write_surface_stl(const ExportModel& model, ExportTexts& files) {
  static_assert(std::endian::native == std::endian::little, "STL is little-endian");
  constexpr std::size_t header_bytes = 80, triangle_bytes = 50;
  const TetMesh& mesh = model.mesh;
  const auto count = static_cast<std::uint32_t>(mesh.surface.size());
  // A header that begins with "solid" would pass for the ASCII form.
  std::string header = ("binary STL, " + model.comment).substr(0, header_bytes);
  header.resize(header_bytes, '\0');
  Text& out = files.begin(".stl");
  out << header << std::string_view(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Triangle& t : mesh.surface) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    Eigen::Matrix<float, 3, 4> numbers;
    numbers << (b - a).cross(c - a).normalized().cast<float>(), a.cast<float>(), b.cast<float>(),
        c.cast<float>();
    std::array<char, triangle_bytes> record{};
    std::memcpy(record.data(), numbers.data(), sizeof(float) * 12);
    out << std::string_view(record.data(), record.size());
  }
}

}  // namespace isochor
