#pragma once
#include <compare>
#include <cstdint>
#include <vector>

#include "core/mesh_input/axis_lines.h"

namespace isochor {

/// Parallel lines along an axis that sample the inside of a soup: a square grid of them over its box, off any
/// regular pattern of it.
class Columns {
 public:
  struct Crossing {
    std::int32_t column;
    float depth;
    std::int8_t sense;  ///< of the triangle along the column, ±1
    std::int32_t triangle;
    auto operator<=>(const Crossing&) const = default;
  };

  /// 64 a side, or as many fewer as keep the crossings in proportion to the triangles.
  Columns(const TriangleSoup& soup, const Box& box, int axis);

  /// Column by column, in order along each.
  std::vector<Crossing> crossings(const TriangleSoup& soup) const;
  double area() const { return width_ * width_; }  ///< of a column's cross-section

 private:
  int a_side_;
  double width_;
  AxisLines lines_;
};

}  // namespace isochor
