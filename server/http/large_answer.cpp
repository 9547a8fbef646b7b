#include "server/http/large_answer.h"

#include <utility>

#include "server/http/service.h"
#include "server/memory_reserve.h"

namespace isochor {

LargeAnswer::LargeAnswer(std::string text, Disposal& disposal) : bytes(std::move(text)) {
  if (bytes.size() <= most_in_memory) return;
  try {
    const auto written = disposal.share(std::make_unique<NamelessFile>());
    written->append(bytes);
    file = written;
    std::string().swap(bytes);  // an assignment would keep its memory
  } catch (const RefusalException&) {
    // No room on the disk.
  }
}

Response respond_with(const std::shared_ptr<const LargeAnswer>& answer) {
  Response response;
  if (!answer->file) {
    response.body = SharedBytes(answer, &answer->bytes);
    return response;
  }
  response.file = std::shared_ptr<const NamelessFile>(answer, answer->file.get());
  return_free_memory();  // each worker would keep what its last text took
  return response;
}

}  // namespace isochor
