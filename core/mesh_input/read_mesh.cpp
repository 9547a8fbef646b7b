#include "core/mesh_input/read_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string>

#include "core/common/error.h"
#include "core/mesh_input/glb_reader.h"
#include "core/mesh_input/polygon_soup.h"

namespace isochor {
namespace {

CheckedMesh check(std::span<const char> bytes, MeshFormat format) {
  switch (format) {
    case MeshFormat::obj:
      return check_obj(bytes);
    case MeshFormat::stl:
      return check_stl(bytes);
    case MeshFormat::ply:
      return check_ply(bytes);
    case MeshFormat::off:
      return check_off(bytes);
    case MeshFormat::glb:
      break;
  }
  throw Error(ErrorCode::internal, "a GLB is not checked here");
}

/// What to do about a file whose first bytes speak of something else than its format, or nothing.
std::string advice(std::string_view bytes, std::string_view format) {
  constexpr std::pair<std::string_view, std::string_view> formats[]{
      {"ply", "PLY"},    {"glTF", "GLB"}, {"OFF", "OFF"}, {"COFF", "OFF"},
      {"solid ", "STL"}, {"v ", "OBJ"},   {"# ", "OBJ"}};
  constexpr std::pair<std::string_view, const char*> others[]{
      {"\xff\xfe", "it is UTF-16 text: save it as UTF-8"},
      {"\xfe\xff", "it is UTF-16 text: save it as UTF-8"},
      {"\x1f\x8b", "it is compressed: unpack it first"},
      {"PK\x03\x04", "it is an archive: unpack it first"},
      {"<", "it is a web page or XML: download the mesh itself"},
      {"version https://git-lfs", "it is a pointer of Git LFS: fetch the mesh itself with git lfs pull"}};
  for (const auto& [beginning, name] : formats)
    if (bytes.starts_with(beginning) && name != format)
      return fmt::format("it begins like {}: is {} the right format?", name, format);
  for (const auto& [beginning, hint] : others)
    if (bytes.starts_with(beginning)) return hint;
  return {};
}

TriangleSoup read_polygons(std::span<const char> bytes, MeshFormat format, Progress& progress) {
  const CheckedMesh mesh = check(bytes, format);
  progress.throw_if_cancelled();
  if (mesh.polygons == 0) return {std::vector<Vec3>(mesh.vertices > 0 ? 1 : 0, Vec3::Zero()), {}};
  return triangulate(read_with_cgal(mesh, format, progress), progress);
}

/// A file that is something else under this format's name is told so.
TriangleSoup read_as(std::span<const char> bytes, MeshFormat format, Progress& progress) {
  constexpr std::array<std::string_view, 5> names{"OBJ", "STL", "PLY", "OFF",
                                                  "GLB"};  // in the order of MeshFormat
  try {
    return format == MeshFormat::glb ? read_glb(bytes) : read_polygons(bytes, format, progress);
  } catch (const Error& error) {
    std::string hint = advice({bytes.data(), bytes.size()}, names[static_cast<std::size_t>(format)]);
    if (hint.empty() && error.hint().empty()) hint = "mend the file there, or export the mesh anew";
    if (error.code() != ErrorCode::cannot_read || hint.empty()) throw;
    throw Error(error.code(), error.what(), std::move(hint));
  }
}

std::string read_bytes(const std::filesystem::path& path) {
  std::error_code failure;
  if (!std::filesystem::exists(path, failure))
    throw Error(ErrorCode::cannot_read, fmt::format("{}: no such file", path.string()), "check the path");
  if (!std::filesystem::is_regular_file(path, failure))
    throw Error(ErrorCode::cannot_read, fmt::format("{}: this is no file", path.string()),
                "name a mesh file, or give - and pipe one in");
  std::string bytes(std::filesystem::file_size(path), '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    throw Error(ErrorCode::cannot_read, fmt::format("{}: cannot be read", path.string()),
                "check its permissions");
  return bytes;
}

}  // namespace

MeshFormat mesh_format(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".obj") return MeshFormat::obj;
  if (extension == ".stl") return MeshFormat::stl;
  if (extension == ".ply") return MeshFormat::ply;
  if (extension == ".off") return MeshFormat::off;
  if (extension == ".glb") return MeshFormat::glb;
  throw Error(ErrorCode::unsupported_format,
              fmt::format("{}: \"{}\" is not a mesh format that is read here", path.string(), extension),
              "use OBJ, STL, PLY, OFF or GLB");
}

TriangleSoup read_mesh(const std::filesystem::path& path, Progress& progress) {
  const MeshFormat format = mesh_format(path);
  const std::string bytes = read_bytes(path);
  try {
    return read_mesh(bytes, format, progress);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    throw Error(error.code(), fmt::format("{}: {}", path.string(), error.what()), error.hint());
  }
}

TriangleSoup read_mesh(std::span<const char> bytes, MeshFormat format, Progress& progress) {
  progress.report("reading", 0.0);
  TriangleSoup soup = read_as(bytes, format, progress);
  if (soup.triangles.empty())
    throw Error(ErrorCode::empty_result, "the mesh has no triangle",
                soup.positions.empty()
                    ? "export it with its faces"
                    : "points, lines and free-form surfaces are not read: make triangles of "
                      "them first");
  progress.report("reading", 1.0);
  return soup;
}

}  // namespace isochor
