#include "core/mesh_input/topology.h"

#include <bit>
#include <cmath>
#include <limits>

#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

/// Of the box's longest edge: seams are round-off apart.
constexpr double same_position = 1e-9;

std::uint64_t hash(const Vec3& p) {
  std::uint64_t h = 0;
  for (int axis = 0; axis < 3; ++axis) {
    h ^= std::bit_cast<std::uint64_t>(p[axis] + 0.0);  // −0 + 0 = 0
    h *= 0x9e3779b97f4a7c15U;                          // Fibonacci hashing [Knuth, vol. 3, 6.4]
    h ^= h >> 29;
  }
  return h;
}

/// Vertices by the cube that holds them. A cube is four tolerances wide, so that few vertices share one and
/// few lie near a neighbour.
class VertexTable {
 public:
  VertexTable(const std::vector<Vec3>& positions, double tolerance)
      : positions_(positions), tolerance_(tolerance), table_(std::bit_ceil(2 * positions.size() + 1), -1) {}

  /// The lowest vertex within the tolerance, or -1.
  std::int32_t find(const Vec3& p) const {
    std::int32_t found = -1;
    const Vec3 low = cube(p - Vec3::Constant(tolerance_)), high = cube(p + Vec3::Constant(tolerance_));
    Vec3 at;
    for (at.z() = low.z(); at.z() <= high.z(); at.z() = next(at.z()))
      for (at.y() = low.y(); at.y() <= high.y(); at.y() = next(at.y()))
        for (at.x() = low.x(); at.x() <= high.x(); at.x() = next(at.x())) search(at, p, found);
    return found;
  }
  void insert(std::int32_t v) {
    std::size_t slot = hash(cube(positions_[v])) & (table_.size() - 1);
    while (table_[slot] >= 0) slot = (slot + 1) & (table_.size() - 1);
    table_[slot] = v;
  }

 private:
  Vec3 cube(const Vec3& p) const {
    return tolerance_ > 0.0 ? Vec3((p / (4.0 * tolerance_)).array().floor()) : p;
  }
  /// Not a number where there is none: beyond 2⁵³, of which infinity is a case (far from the origin for the
  /// tolerance), and without a tolerance. It ends the loops, which infinity would not.
  double next(double at) const {
    return tolerance_ > 0.0 && at + 1.0 > at ? at + 1.0 : std::numeric_limits<double>::quiet_NaN();
  }

  void search(const Vec3& at, const Vec3& p, std::int32_t& found) const {
    for (std::size_t slot = hash(at) & (table_.size() - 1); table_[slot] >= 0;
         slot = (slot + 1) & (table_.size() - 1)) {
      const std::int32_t v = table_[slot];
      if ((found < 0 || v < found) && (positions_[v] - p).cwiseAbs().maxCoeff() <= tolerance_) found = v;
    }
  }

  const std::vector<Vec3>& positions_;
  double tolerance_;
  std::vector<std::int32_t> table_;
};

}  // namespace

std::vector<std::int32_t> merge_vertices(const std::vector<Vec3>& positions, double tolerance) {
  std::vector<std::int32_t> first(positions.size());
  VertexTable table(positions, tolerance);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (v % 4096 == 0) throw_if_scope_cancelled();
    const std::int32_t found = table.find(positions[v]);
    first[v] = found < 0 ? static_cast<std::int32_t>(v) : found;
    if (found < 0) table.insert(first[v]);
  }
  return first;
}

std::vector<std::int32_t> merge_vertices(const TriangleSoup& soup) {
  return merge_vertices(soup.positions, same_position * bounding_box(soup).size().maxCoeff());
}

}  // namespace isochor
