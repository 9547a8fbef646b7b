#pragma once
#include <filesystem>
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
  std::string_view extension;  ///< ".msh"; of a set of files the first one's
  std::string_view media_type;
  std::string_view consumers;    ///< "Gmsh, SOFA, DART"
  std::string_view conventions;  ///< index base, winding, units: one sentence
  bool is_set = false;           ///< of several files
};
std::span<const ExportFormat> export_formats();

/// By name, or by extension (".msh", any case): the first of the table that has it. Throws
/// unsupported_format.
const ExportFormat& export_format(std::string_view name_or_extension);

/// That of a file, by the longest extension its name ends in: ".embedding.json" before ".json".
const ExportFormat& export_format_of(const std::filesystem::path& file);

struct ExportFile {
  std::string name_suffix;  ///< ".node"; appended to the chosen stem
  std::string content;
};

/// What an exporter sees: the model, and a one-line description of the parameters for the file's comment.
struct ExportModel {
  const TetMesh& mesh;
  const Embedding* embedding = nullptr;  ///< needed by "embedding" only
  std::string comment;
  std::string stem = "model";  ///< file name without extension, for files that name each other
};

/// The same bytes for the same model. Throws invalid_argument when the format needs an embedding and there
/// is none.
std::vector<ExportFile> export_model(const ExportModel& model, const ExportFormat& format);

/// Takes the files of a set one after another, each a piece at a time.
class ExportSink {
 public:
  virtual ~ExportSink() = default;
  virtual void begin(std::string_view name_suffix) = 0;
  virtual void write(std::string_view bytes) = 0;
};
/// The same without holding a file in memory.
void export_model(const ExportModel& model, const ExportFormat& format, ExportSink& sink);

/// Where the files of a set go: a single one to the target itself, several to its stem and their suffixes.
std::vector<std::filesystem::path> export_paths(const std::filesystem::path& target,
                                                std::span<const ExportFile> files);

}  // namespace isochor
