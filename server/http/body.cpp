#include "server/http/body.h"

#include <atomic>

#include "server/http/nameless_file.h"

namespace isochor {
namespace {

std::atomic<std::size_t> in_files{0};

}  // namespace

class Body::File {
 public:
  File() = default;
  ~File() { in_files -= file_.size(); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void append(std::string_view bytes) {
    const std::size_t before = file_.size();
    try {
      file_.append(bytes);
    } catch (...) {
      in_files += file_.size() - before;
      throw;
    }
    in_files += file_.size() - before;
  }
  std::string_view map() { return file_.map(); }

 private:
  NamelessFile file_;
};

void Body::append(std::string_view bytes) {
  if (bytes.empty()) return;
  if (!in_file()) {
    text_.reserve(declared_);
    text_ += bytes;
  } else {
    if (!file_) file_ = std::make_shared<File>();
    file_->append(bytes);
  }
  size_ += bytes.size();
}

std::string_view Body::view() const {
  return file_ ? file_->map() : std::string_view(text_);
}

std::size_t Body::bytes_in_files() {
  return in_files;
}

}  // namespace isochor
