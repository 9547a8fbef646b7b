#include "server/http/large_answer.h"

#include <utility>

#include "server/http/service.h"

namespace isochor {

void LargeAnswer::append(std::string_view piece) {
  if (bytes_.size() + piece.size() > most_in_memory) use_file();
  if (!file_) {
    bytes_ += piece;
    return;
  }
  const std::size_t before = size();
  try {
    file_->append(piece);
  } catch (const RefusalException&) {
    leave_file(before);
    bytes_ += piece;
  }
}

void LargeAnswer::overwrite(std::size_t offset, std::string_view bytes) {
  if (file_)
    file_->overwrite(offset, bytes);
  else
    bytes_.replace(offset, bytes.size(), bytes);
}

void LargeAnswer::use_file() {
  if (std::exchange(tried_file_, true)) return;
  try {
    file_ = disposal_.share(std::make_unique<NamelessFile>());
    file_->append(bytes_);
    std::string().swap(bytes_);  // an assignment would keep its memory
  } catch (const RefusalException&) {
    file_ = nullptr;
  }
}

void LargeAnswer::leave_file(std::size_t whole_bytes) {
  bytes_ = file_->map().substr(0, whole_bytes);
  file_ = nullptr;
}

Response LargeAnswer::respond(const std::shared_ptr<const void>& owner) const {
  Response response;
  if (file_)
    response.file = std::shared_ptr<const NamelessFile>(owner, file_.get());
  else
    response.body = SharedBytes(owner, &bytes_);
  return response;
}

}  // namespace isochor
