#pragma once
#include <sys/types.h>

#include <cstddef>
#include <string_view>

namespace isochor {

/// A file without a name, in $TMPDIR or /var/tmp, for what is large and whose peer may be slow: it takes no
/// memory that the system could not have back.
class NamelessFile {
 public:
  /// Throws a refusal, 507, as append() does where there is no room.
  NamelessFile();
  ~NamelessFile();
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  void append(std::string_view bytes);
  void overwrite(std::size_t offset, std::string_view bytes);  ///< within its size
  std::size_t size() const { return size_; }
  /// All of it; it stays while the file lives.
  std::string_view map();
  /// As send(2) does, of what follows offset.
  ssize_t send(int socket, std::size_t offset) const;

 private:
  int descriptor_;
  std::size_t size_ = 0;
  void* mapped_ = nullptr;
};

}  // namespace isochor
