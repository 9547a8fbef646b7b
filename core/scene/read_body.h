#pragma once
#include "core/scene/json_fields.h"
#include "core/scene/scene.h"

namespace isochor {

/// One entry of a scene's "bodies". Mesh paths are resolved against base_folder.
SceneBody read_body(const Json& json, const std::string& pointer, const std::filesystem::path& base_folder,
                    std::vector<ErrorDetail>& faults);

AxisBox read_axis_box(const Json& json, const std::string& pointer, std::vector<ErrorDetail>& faults);

/// Values of the parameter table; faults get the pointer as their prefix.
MeshingOptions read_meshing(const Json& json, const std::string& pointer, std::vector<ErrorDetail>& faults);

}  // namespace isochor
