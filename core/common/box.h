#pragma once
#include "core/common/types.h"

namespace isochor {

/// Axis-aligned; as it begins it holds nothing.
struct Box {
  Vec3 min = Vec3::Constant(1e300), max = Vec3::Constant(-1e300);
  void extend(const Vec3& p) { min = min.cwiseMin(p), max = max.cwiseMax(p); }
  Vec3 size() const { return max - min; }
  Vec3 center() const { return 0.5 * (min + max); }
};

inline bool overlaps(const Box& a, const Box& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}
inline Box grown(const Box& box, double by) {
  return {box.min - Vec3::Constant(by), box.max + Vec3::Constant(by)};
}

}  // namespace isochor
