#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "server/http/message.h"

namespace isochor {

/// A file's bytes; none where it cannot be read.
std::string read_all(const std::filesystem::path& file);

/// The page's files, read once at the start: no path from a request ever reaches the file system.
class Assets {
 public:
  /// Takes the folder's files. token fills the meta element isochor-token of the HTML; empty leaves it empty.
  Assets(const std::filesystem::path& web_folder, const std::string& token);

  /// path as in the URL; nullopt when there is no such file. Gzip for those who accept it.
  std::optional<Response> find(const Request& request) const;
  bool empty() const { return files_.empty(); }

 private:
  struct File {
    std::string content_type, etag;
    bool is_page = false;
    SharedBytes plain, gzip;
  };
  void add(const std::filesystem::path& file, const std::string& url, const std::string& token);

  std::map<std::string, File, std::less<>> files_;
};

}  // namespace isochor
