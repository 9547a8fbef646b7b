#include "core/mesh_input/check.h"

#include <fmt/format.h>

#include "core/common/error.h"

namespace isochor {

void throw_bad_index(const std::string& where, std::int64_t index, std::int64_t first,
                     std::int64_t vertices) {
  throw Error(ErrorCode::cannot_read,
              fmt::format("{}: the vertex index {} is out of range: the file has {} vertices", where, index,
                          vertices),
              fmt::format("indices of this format start at {}; the file may be truncated", first));
}

}  // namespace isochor
