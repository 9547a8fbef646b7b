#include "server/report/report_page.h"

#include <array>
#include <fstream>
#include <iterator>
#include <span>
#include <utility>

#include "core/common/error.h"
#include "server/messages/json_text.h"

namespace isochor {
namespace {

std::string read_part(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(ErrorCode::cannot_read, "cannot read " + path.string(),
                "the page's files belong beside the program; build again");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string module_url(const std::filesystem::path& path) {
  const std::string text = read_part(path);
  std::string url = "data:text/javascript;base64,";
  append_base64(url, std::as_bytes(std::span(text)));
  return url;
}

/// Inside a script element only "</" could end it early.
std::string inside_script(std::string_view json) {
  std::string safe;
  for (char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

}  // namespace

std::string make_report_page(std::string_view report_json, const std::filesystem::path& web_folder) {
  const std::filesystem::path uplot = web_folder / "node_modules/uplot/dist", own = web_folder / "report";
  const std::array<std::pair<std::string_view, std::string>, 7> parts{{
      {"{{uplot_css}}", read_part(uplot / "uPlot.min.css")},
      {"{{report_css}}", read_part(own / "report.css")},
      {"{{uplot_module}}", module_url(uplot / "uPlot.esm.js")},
      {"{{curves_module}}", module_url(own / "curves.js")},
      {"{{stability_map_module}}", module_url(own / "stability_map.js")},
      {"{{report_module}}", read_part(own / "report.js")},
      {"{{report}}", inside_script(report_json)},
  }};
  const std::string page = read_part(own / "report.html");
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
