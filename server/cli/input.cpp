#include "server/cli/input.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace isochor {
namespace {

std::string read_stdin() {
  std::string bytes;
  std::string buffer(std::size_t{1} << 16, '\0');
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), stdin))
    bytes.append(buffer, 0, count);
  if (std::ferror(stdin) != 0) throw Error(ErrorCode::cannot_read, "cannot read from stdin");
  return bytes;
}

MeshFormat format_of(const InputOptions& options) {
  if (!options.format.empty()) return mesh_format("stdin." + options.format);
  if (options.path == "-")
    throw Error(ErrorCode::invalid_argument, "the format of a mesh from stdin is not known",
                "add --input-format, e.g. --input-format obj");
  return mesh_format(options.path);
}

}  // namespace

void add_input_options(CLI::App& command, InputOptions& options) {
  command.add_option("INPUT", options.path, "Triangle mesh: obj, stl, ply, off or glb; - reads stdin")
      ->required();
  command.add_option("--input-format", options.format,
                     "Format of INPUT (obj, stl, ply, off, glb) where its name does not tell");
}

std::string read_bytes(const std::string& path) {
  if (path == "-") return read_stdin();
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw Error(ErrorCode::cannot_read,
                fmt::format("cannot read {}: {}", path, std::strerror(errno != 0 ? errno : EISDIR)),
                "check the path and its permissions");
  return {std::istreambuf_iterator<char>(file), {}};
}

InputMesh read_input(const InputOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const MeshFormat format = format_of(options);
  InputMesh input;
  if (options.path == "-" || !options.format.empty()) {
    const std::string bytes = read_bytes(options.path);
    input.bytes = static_cast<std::int64_t>(bytes.size());
    input.soup = std::make_shared<TriangleSoup>(read_mesh(bytes, format, progress));
  } else {
    input.soup = std::make_shared<TriangleSoup>(read_mesh(std::filesystem::path(options.path), progress));
    input.bytes = static_cast<std::int64_t>(std::filesystem::file_size(options.path));
  }
  input.read_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return input;
}

}  // namespace isochor
