#include "server/report/report_page.h"

#include <array>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/common/error.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

std::string read_part(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(ErrorCode::cannot_read, "cannot read " + path.string(),
                "the page's files belong beside the program; build again");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Inside a script element only "</" could end it early.
std::string inside_script(std::string_view json) {
  std::string safe;
  for (char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

}  // namespace

std::string make_report_page(std::string_view report_json, const fs::path& web_folder) {
  const fs::path folder = web_folder / "report";
  const std::array<std::pair<std::string_view, std::string>, 3> parts{{
      {"{{report_css}}", read_part(folder / "bundle/report.css")},
      {"{{report_js}}", read_part(folder / "bundle/report.js")},
      {"{{report}}", inside_script(report_json)},
  }};
  const std::string page = read_part(folder / "report.html");
  std::string filled;
  for (std::size_t at = 0; at < page.size();) {
    std::size_t next = page.find("{{", at);
    filled.append(page, at, next == std::string::npos ? next : next - at);
    if (next == std::string::npos) break;
    const std::size_t end = page.find("}}", next);
    const std::string_view mark = std::string_view(page).substr(next, end + 2 - next);
    for (const auto& [name, text] : parts)
      if (name == mark) filled += text;
    at = end + 2;
  }
  return filled;
}

}  // namespace isochor
