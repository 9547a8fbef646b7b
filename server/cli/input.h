#pragma once
#include <memory>
#include <string>

#include "core/mesh_input/read_mesh.h"
#include "server/cli/context.h"

namespace isochor {

/// A mesh from a file or from stdin.
struct InputOptions {
  std::string path;    ///< "-" is stdin
  std::string format;  ///< extension without the dot; needed for stdin, else from the file's name
};
/// Adds INPUT and --input-format.
void add_input_options(CLI::App& command, InputOptions& options);

struct InputMesh {
  std::shared_ptr<const TriangleSoup> soup;
  std::int64_t bytes = 0;
  double read_ms = 0.0;
};
/// Throws what read_mesh throws.
InputMesh read_input(const InputOptions& options, Progress& progress);

/// The bytes of stdin or of a file. Throws cannot_read.
std::string read_bytes(const std::string& path);

}  // namespace isochor
