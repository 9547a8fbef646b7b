#pragma once
#include <array>
#include <optional>

#include "core/common/types.h"

namespace isochor {

using TrianglePoints = std::array<Vec3, 3>;

/// Unit normal; zero for a degenerate triangle.
Vec3 normal_of(const TrianglePoints& triangle);
/// Weights of the triangle's point on the line through p along the direction; they sum to 1 and lie outside
/// [0, 1] where the line passes the triangle. Nothing when the line runs along the triangle's plane.
std::optional<Vec3> weights_along(const Vec3& p, const Vec3& direction, const TrianglePoints& triangle);
/// Is every weight in [−slack, 1 + slack]?
inline bool is_within(const Vec3& weights, double slack) {
  return weights.minCoeff() >= -slack;
}

/// A vertex and a triangle over a substep; both move on straight lines.
struct VertexSweep {
  Vec3 from, to;
  TrianglePoints start, end;

  /// When the vertex goes through the triangle from front to back without coming out again, as a fraction of
  /// the substep. One that starts behind it by up to `depth` counts as having come from the front; one
  /// that ends behind it by no more than the slop has not gone through. Triangles reach beyond their edges by
  /// the seam, in weights, so that nothing slips through between them.
  std::optional<double> entry(double depth, double slop = 0.0, double seam = 1e-4) const;

 private:
  /// Positive in front; twice the area times the height.
  double side(double time) const;
  bool passes_by(double seam) const;
  Vec3 vertex_at(double time) const { return from + time * (to - from); }
  TrianglePoints triangle_at(double time) const;
};

}  // namespace isochor
