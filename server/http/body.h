#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace isochor {

/// The body of a request, from its first byte until the request is answered: a small one in memory, a larger
/// one in a file without a name (in $TMPDIR, or /var/tmp), so that what is sent and not finished takes no
/// memory.
class Body {
 public:
  static constexpr std::size_t most_in_memory = 8 * 1024;

  Body() = default;
  explicit Body(std::size_t declared) : declared_(declared) {}

  bool in_file() const { return declared_ > most_in_memory; }
  std::size_t missing() const { return declared_ - size_; }
  /// At most what is missing. Throws a refusal, 507, when there is no room on the disk.
  void append(std::string_view bytes);
  std::size_t bytes_in_memory() const { return text_.empty() ? 0 : declared_; }

  /// What has come; of a file it is mapped, and stays while the body lives.
  std::string_view view() const;
  operator std::string_view() const { return view(); }

  /// Bytes of all bodies of this process that are in files.
  static std::size_t bytes_in_files();

 private:
  class File;
  std::size_t declared_ = 0, size_ = 0;
  std::string text_;
  std::shared_ptr<File> file_;
};

}  // namespace isochor
