#pragma once
#include <filesystem>
#include <string_view>

namespace isochor {

/// A folder that ships with the program ("samples", "web"): <prefix>/share/isochor/NAME when installed, else
/// that of the source tree around the executable. Empty when there is none.
std::filesystem::path data_folder(std::string_view name);

}  // namespace isochor
