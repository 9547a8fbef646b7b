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
  // Nobody reads the counter: it is full after 2^64 wakes.
  [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);
}

}  // namespace isochor
