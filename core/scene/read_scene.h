#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "core/scene/scene.h"

namespace isochor {

/// Reads the JSON form of a scene. Relative mesh paths are taken from base_folder. Every faulty or unknown
/// field is listed by its JSON pointer. Throws cannot_read (syntax, with the byte), invalid_argument.
Scene read_scene(std::string_view json, const std::filesystem::path& base_folder);
Scene read_scene_file(const std::filesystem::path& path);

/// Values of the parameter table from a JSON object (a params file, or a scene's "meshing").
MeshingOptions read_meshing_options(std::string_view json);
std::string write_meshing_options(const MeshingOptions& options);

}  // namespace isochor
