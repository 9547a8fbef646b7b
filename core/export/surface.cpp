#include <bit>
#include <cstring>

#include "core/export/text.h"
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

std::vector<ExportFile> write_surface_obj(const ExportModel& model) {
  const BoundarySurface surface = boundary_surface(model.mesh);
  Text text;
  text << "# " << model.comment << '\n';
  for (const std::int32_t vertex : surface.vertex) text << "v " << model.mesh.positions[vertex] << '\n';
  for (const Triangle& triangle : surface.triangles) (text << "f ").list(triangle, ' ', 1) << '\n';
  return {{".obj", text.take()}};
}

std::vector<ExportFile> write_surface_ply(const ExportModel& model) {
  const BoundarySurface surface = boundary_surface(model.mesh);
  Text text;
  text << "ply\nformat ascii 1.0\ncomment " << model.comment << "\nelement vertex " << surface.vertex.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
       << surface.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const std::int32_t vertex : surface.vertex) text << model.mesh.positions[vertex] << '\n';
  for (const Triangle& triangle : surface.triangles) text << "3 " << triangle << '\n';
  return {{".ply", text.take()}};
}

std::vector<ExportFile> write_surface_stl(const ExportModel& model) {
  static_assert(std::endian::native == std::endian::little, "STL is little-endian");
  constexpr std::size_t header_bytes = 80, triangle_bytes = 50;
  const TetMesh& mesh = model.mesh;
  const auto count = static_cast<std::uint32_t>(mesh.surface.size());
  std::string bytes(header_bytes + sizeof count + triangle_bytes * count, '\0');
  // A header that begins with "solid" would pass for the ASCII form.
  const std::string header = ("binary STL, " + model.comment).substr(0, header_bytes);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::memcpy(bytes.data() + header_bytes, &count, sizeof count);
  char* out = bytes.data() + header_bytes + sizeof count;
  for (const Triangle& t : mesh.surface) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    Eigen::Matrix<float, 3, 4> record;
    record << (b - a).cross(c - a).normalized().cast<float>(), a.cast<float>(), b.cast<float>(),
        c.cast<float>();
    std::memcpy(out, record.data(), sizeof(float) * 12);
    out += triangle_bytes;
  }
  return {{".stl", std::move(bytes)}};
}

}  // namespace isochor
