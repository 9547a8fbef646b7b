#pragma once
#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/embedding/embedding.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// One verified dialect per consumer.
struct ExportFormat {
  std::string_view name;       ///< "msh2", "msh4", "vtu", … as in /models/{id}/exports/{format}
  std::string_view extension;  ///< ".msh"; several files become one .zip-free set, see write_model
  std::string_view media_type;
  std::string_view consumers;    ///< "Gmsh, SOFA, DART"
  std::string_view conventions;  ///< index base, winding, units: one sentence
};
std::span<const ExportFormat> export_formats();

/// By name, or by extension where that is unambiguous. Throws unsupported_format.
const ExportFormat& export_format(std::string_view name_or_extension);

struct ExportFile {
  std::string name_suffix;  ///< ".node"; appended to the chosen stem
  std::string content;
};

/// What an exporter sees: the model, and a one-line description of the parameters for the file's comment.
struct ExportModel {
  const TetMesh& mesh;
  const Embedding* embedding = nullptr;  ///< needed by "embedding" only
  std::string comment;
};

/// The same bytes for the same model. Throws unsupported_format.
std::vector<ExportFile> export_model(const ExportModel& model, const ExportFormat& format);

/// Writes beside the target and renames, so that nothing is ever half-written. Throws cannot_write.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace isochor
