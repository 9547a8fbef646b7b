#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace isochor {

/// A file that appears whole or not at all: it is written beside its target and renamed over it by commit().
/// Without a commit nothing is left. "-" is stdout; it, and a target that is no regular file (a pipe, a
/// device), is written straight through. Throws cannot_write.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  /// To the disk, so that what commit() names is complete even after a crash.
  void sync();
  void commit();

 private:
  void close();

  std::filesystem::path target_, beside_;  ///< beside_ is empty when written straight through
  int descriptor_ = -1;
};

/// Removes from a folder the files that were beside their targets when the programs that wrote them were
/// killed. Those of programs that run stay.
void remove_abandoned(const std::filesystem::path& folder);

void write_file(const std::filesystem::path& path, std::string_view content);

/// All of a set, or none as far as the disk allows: every file is complete beside its target before the
/// first one is renamed.
struct NamedContent {
  std::filesystem::path path;
  std::string_view content;
};
void write_files(std::span<const NamedContent> files);

}  // namespace isochor
