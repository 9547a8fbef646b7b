#include "server/report/report_page.h"

#include <array>
#include <fstream>
#include <iterator>
#include <regex>
#include <span>
#include <utility>

#include "core/common/error.h"
#include "server/messages/json_text.h"

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

/// A module whose imports are names of the page's import map: a data: URL has no folder that '../ui/dom.js'
/// could start from.
std::string read_module(const fs::path& path) {
  static const std::regex relative("from '[./]+(?:\\w+/)*(\\w+)\\.js'");
  return std::regex_replace(read_part(path), relative, "from '$1'");
}

std::string import_map(const fs::path& web_folder) {
  std::string map;
  for (const char* module :
       {"ui/dom.js", "ui/roving.js", "report/error_plot.js", "report/stability_map.js"}) {
    const std::string text = read_module(web_folder / module);
    map += (map.empty() ? "{\"imports\":{\"" : ",\"") + fs::path(module).stem().string() +
           "\":\"data:text/javascript;base64,";
    append_base64(map, std::as_bytes(std::span(text)));
    map += '"';
  }
  return map + "}}";
}

/// Inside a script element only "</" could end it early.
std::string inside_script(std::string_view json) {
  std::string safe;
  for (char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

}  // namespace

std::string make_report_page(std::string_view report_json, const fs::path& web_folder) {
  const std::array<std::pair<std::string_view, std::string>, 5> parts{{
      {"{{plots_css}}", read_part(web_folder / "styles/plots.css")},
      {"{{report_css}}", read_part(web_folder / "report/report.css")},
      {"{{modules}}", import_map(web_folder)},
      {"{{report_module}}", read_module(web_folder / "report/report.js")},
      {"{{report}}", inside_script(report_json)},
  }};
  const std::string page = read_part(web_folder / "report/report.html");
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
