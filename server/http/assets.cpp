#include "server/http/assets.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "server/store/content_id.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr std::array media_types{std::pair{".html"sv, "text/html; charset=utf-8"sv},
                                 std::pair{".js"sv, "text/javascript; charset=utf-8"sv},
                                 std::pair{".mjs"sv, "text/javascript; charset=utf-8"sv},
                                 std::pair{".css"sv, "text/css; charset=utf-8"sv},
                                 std::pair{".svg"sv, "image/svg+xml"sv},
                                 std::pair{".png"sv, "image/png"sv},
                                 std::pair{".ico"sv, "image/x-icon"sv},
                                 std::pair{".woff2"sv, "font/woff2"sv},
                                 std::pair{".webmanifest"sv, "application/manifest+json"sv}};

std::string_view media_type(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const auto& [suffix, type] : media_types)
    if (suffix == extension) return type;
  return {};
}

std::string gzip(const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const bool done = deflate(&stream, Z_FINISH) == Z_STREAM_END;
  out.resize(done ? stream.total_out : 0);
  deflateEnd(&stream);
  return out;
}

std::string with_token(std::string html, const std::string& token) {
  constexpr std::string_view place = R"(name="isochor-token" content=")";
  const std::size_t at = html.find(place);
  if (at != std::string::npos) html.insert(at + place.size(), token);
  return html;
}

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (auto it = fs::recursive_directory_iterator(folder, none); it != fs::recursive_directory_iterator();
       ++it) {
    if (it->is_directory() && it->path().filename() == "node_modules")
      it.disable_recursion_pending();
    else if (it->is_regular_file() && !media_type(it->path()).empty())
      files.push_back(it->path());
  }
  return files;
}

bool accepts_gzip(const Request& request) {
  const std::string* accepted = request.header("accept-encoding");
  return accepted && accepted->find("gzip") != std::string::npos;
}

}  // namespace

std::string read_all(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return std::move(out).str();
}

Assets::Assets(const fs::path& web_folder, const std::string& token) {
  if (web_folder.empty()) return;
  for (const fs::path& file : files_below(web_folder))
    add(file, (fs::path("/") / file.lexically_relative(web_folder)).generic_string(), token);
  if (const auto index = files_.find("/index.html"); index != files_.end()) files_["/"] = index->second;
}

void Assets::add(const fs::path& path, const std::string& url, const std::string& token) {
  File file;
  file.content_type = media_type(path);
  file.is_page = path.extension() == ".html";
  std::string text = file.is_page ? with_token(read_all(path), token) : read_all(path);
  file.etag = '"' + content_id("", text) + '"';
  const bool compressible =
      file.content_type.starts_with("text/") || file.content_type.find('+') != std::string::npos;
  // The token shares no compressed answer with anything that a stranger chose.
  if (compressible && !file.is_page) file.gzip = std::make_shared<const std::string>(gzip(text));
  file.plain = std::make_shared<const std::string>(std::move(text));
  files_[url] = std::move(file);
}

std::optional<Response> Assets::find(const Request& request) const {
  const auto found = files_.find(request.path);
  if (found == files_.end()) return std::nullopt;
  const File& file = found->second;
  Response response;
  response.content_type = file.content_type;
  const bool compressed = file.gzip && !file.gzip->empty() && accepts_gzip(request);
  response.body = compressed ? file.gzip : file.plain;
  if (compressed) response.headers.emplace_back("Content-Encoding", "gzip");
  if (file.gzip) response.headers.emplace_back("Vary", "Accept-Encoding");
  // The page holds the token; everything else may be kept, and asked for again by its tag.
  response.headers.emplace_back("Cache-Control", file.is_page ? "no-store" : "no-cache");
  if (!file.is_page) response.headers.emplace_back("ETag", file.etag);
  return response;
}

}  // namespace isochor
