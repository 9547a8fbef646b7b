#include "server/stream/waker.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "core/common/error.h"

namespace isochor {

Waker::Waker() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (descriptor_ < 0) throw Error(ErrorCode::internal, "no descriptor left for an eventfd");
}

Waker::~Waker() {
  close(descriptor_);
}

void Waker::wake() const {
  const std::uint64_t one = 1;
  // A full counter fails with EAGAIN and is awake already.
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);
}

void Waker::clear() const {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(descriptor_, &count, sizeof count);
}

}  // namespace isochor
