#pragma once
#include "core/dynamics/cell_volume_kernel.h"
#include "core/dynamics/newton_kernels.h"
#include "core/dynamics/newton_wide.h"

/// Cells in lanes. Neighbouring cells alternate in parity: an odd cell is an even one with the corners b and
/// b^1 exchanged, so a lane takes either of two loads.
namespace isochor::newton::ISOCHOR_WIDE {

using detail::Point;

inline std::int64_t corner_offset(int corner, Strides strides) {
  return (corner & 1) + (corner >> 1 & 1) * strides.row + (corner >> 2 & 1) * strides.plane;
}

/// Corners as an even cell names them.
template <class V>
struct CentralAndApexes {
  Point<V> central[4], apexes[4];

  Point<V>& operator[](int corner) {
    for (int i = 0; i < 4; ++i) {
      if (corner == detail::central_corners[i]) return central[i];
      if (corner == (detail::central_corners[i] ^ 7)) return apexes[i];
    }
    __builtin_unreachable();
  }
};

/// Exchanges the corners b and b^1 of odd cells.
template <class V, class Mask>
inline void exchange(CentralAndApexes<V>& cells, const Mask& odd) {
#pragma GCC unroll 4
  for (int b = 0; b < 8; b += 2) {
    const Point<V> p = cells[b], q = cells[b + 1];
    cells[b] = {odd ? q.x : p.x, odd ? q.y : p.y, odd ? q.z : p.z};
    cells[b + 1] = {odd ? p.x : q.x, odd ? p.y : q.y, odd ? p.z : q.z};
  }
}

}  // namespace isochor::newton::ISOCHOR_WIDE
