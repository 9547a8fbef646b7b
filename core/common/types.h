#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace isochor {

using Vec3 = Eigen::Vector3d;
using Vec3i = Eigen::Vector3i;
using Triangle = std::array<std::int32_t, 3>;  ///< vertex indices, counter-clockwise seen from outside
using Tet = std::array<std::int32_t, 4>;       ///< vertex indices, positive: (b−a)·((c−a)×(d−a)) > 0

/// A regular grid of cubes: box i,j,k spans origin + spacing·[i,i+1]×…; x runs fastest in memory.
struct Grid {
  Vec3i size = Vec3i::Zero();
  double spacing = 0.0;  ///< model units
  Vec3 origin = Vec3::Zero();

  std::int64_t count() const { return std::int64_t{size.x()} * size.y() * size.z(); }
  std::int64_t index(int i, int j, int k) const {
    return i + std::int64_t{size.x()} * (j + std::int64_t{size.y()} * k);
  }
  bool contains(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size.x() && j < size.y() && k < size.z();
  }
  Vec3 center(int i, int j, int k) const { return origin + spacing * Vec3(i + 0.5, j + 0.5, k + 0.5); }
  bool operator==(const Grid& other) const = default;
};

/// Signed volume of a tetrahedron, (b−a)·((c−a)×(d−a))/6 [Diziol 2009, Eq. 3].
inline double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).dot((c - a).cross(d - a)) / 6.0;
}

}  // namespace isochor
