#pragma once
#include <memory>
#include <string>

#include "server/http/message.h"
#include "server/job_queue/disposal.h"

namespace isochor {

/// The bytes of an answer for all who read it at the same time: where they are many, in a file, so that slow
/// readers hold no memory.
struct LargeAnswer {
  static constexpr std::size_t most_in_memory = 256 * 1024;

  /// The file ends on the disposal's thread: its pages are freed then. Where there is none to be had, the
  /// bytes stay in memory.
  LargeAnswer(std::string text, Disposal& disposal);

  std::string bytes;
  std::shared_ptr<const NamelessFile> file;  ///< else null
};

Response respond_with(const std::shared_ptr<const LargeAnswer>& answer);

}  // namespace isochor
