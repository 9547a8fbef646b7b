#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/common/types.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {

/// Positions or velocities of a body's particles as a structure of arrays, in the order of
/// TetMesh::positions.
struct Coordinates {
  std::vector<double> x, y, z;

  Coordinates() = default;
  /// Large bodies make many: between them they can be cancelled.
  explicit Coordinates(std::size_t size) : x(size), y(size), z(size) { throw_if_scope_cancelled(); }
  explicit Coordinates(std::span<const Vec3> points) : Coordinates(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) set(i, points[i]);
  }
  std::size_t size() const { return x.size(); }
  Vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Vec3& p) { x[i] = p.x(), y[i] = p.y(), z[i] = p.z(); }
  void add(std::size_t i, const Vec3& d) { x[i] += d.x(), y[i] += d.y(), z[i] += d.z(); }
};

}  // namespace isochor
