#pragma once
#include <cstdint>
#include <span>

#include "core/dynamics/spring_stencil.h"
#include "core/parallel/parallel.h"

namespace isochor {

/// Springs of a run are worked through in blocks, whose forces lie on the stack.
inline constexpr int spring_block = 64;

/// Guards the division for springs of length zero: they push nowhere.
inline constexpr double tiny_length = 1e-200;

/// One coordinate of the forces on the first particles of the springs; those on the second are opposite.
inline void scatter_forces(double* __restrict f, const double* __restrict force, std::int32_t a,
                           std::int32_t b, int count) {
  for (int t = 0; t < count; ++t) f[a + t] += force[t];
  for (int t = 0; t < count; ++t) f[b + t] -= force[t];
}

/// Calls work(runs) for each chunk: the even ones side by side, then the odd ones (see SpringStencil).
template <class Work>
void for_each_chunk(const SpringFamily& family, Work&& work) {
  for (int color = 0; color < 2; ++color) {
    parallel_for((family.chunks() - color + 1) / 2, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const auto first = family.chunk_begin[2 * i + color], last = family.chunk_begin[2 * i + color + 1];
        work(std::span(family.runs.data() + first, static_cast<std::size_t>(last - first)));
      }
    });
  }
}

}  // namespace isochor
