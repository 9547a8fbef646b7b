#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "server/http/message.h"
#include "server/job_queue/disposal.h"

namespace isochor {

/// The bytes of an answer for all who read it at the same time, taken a piece at a time: where they are many,
/// in a file, so that neither making them nor slow readers take memory.
class LargeAnswer {
 public:
  static constexpr std::size_t most_in_memory = 256 * 1024;

  /// The file ends on the disposal's thread: its pages are freed then.
  explicit LargeAnswer(Disposal& disposal) : disposal_(disposal) {}

  /// Where there is no file to be had, or no room in it, all stays in memory.
  void append(std::string_view piece);
  void overwrite(std::size_t offset, std::string_view bytes);  ///< within its size
  std::size_t size() const { return file_ ? file_->size() : bytes_.size(); }

  /// `owner` holds this.
  Response respond(const std::shared_ptr<const void>& owner) const;

 private:
  void use_file();
  void leave_file(std::size_t whole_bytes);

  Disposal& disposal_;
  std::string bytes_;
  std::shared_ptr<NamelessFile> file_;  ///< holds all, or is null
  bool tried_file_ = false;
};

}  // namespace isochor
