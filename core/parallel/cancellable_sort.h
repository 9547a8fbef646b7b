#pragma once
#include <algorithm>
#include <cstdint>

#include "core/parallel/cancel_scope.h"

namespace isochor {

/// std::ranges::sort of millions, which ends soon after the scope of this thread is cancelled.
template <class Range>
void cancellable_sort(Range& values) {
  std::uint32_t comparisons = 0;
  std::ranges::sort(values, [&](const auto& a, const auto& b) {
    if (++comparisons % (1U << 20) == 0) throw_if_scope_cancelled();
    return a < b;
  });
}

}  // namespace isochor
