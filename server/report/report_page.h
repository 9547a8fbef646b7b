#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace isochor {

/// One self-contained HTML page from an encoded report: styles and the drawing code stand inside it,
/// so it opens from a file, offline. Throws cannot_read when the web folder lacks a part.
std::string make_report_page(std::string_view report_json, const std::filesystem::path& web_folder);

}  // namespace isochor
