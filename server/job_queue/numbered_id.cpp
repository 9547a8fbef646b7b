#include "server/job_queue/numbered_id.h"

#include <charconv>

namespace isochor {

bool was_issued(std::string_view id, std::int64_t next) {
  std::int64_t number = 0;
  if (id.size() < 2 || id[1] == '0') return false;
  const auto [end, error] = std::from_chars(id.data() + 1, id.data() + id.size(), number);
  return error == std::errc() && end == id.data() + id.size() && number > 0 && number < next;
}

}  // namespace isochor
