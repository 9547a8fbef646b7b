#pragma once
#include <algorithm>
#include <cmath>

#include "core/common/types.h"

namespace isochor {

/// Cosine of the smallest dihedral angle of a positive tet, that is the largest of −n_f·n_g over its pairs of
/// unit outward face normals. 1 when the volume is below min_volume.
inline double smallest_dihedral_cosine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                       double min_volume = 0.0) {
  const Vec3 e1 = b - a, e2 = c - a, e3 = d - a;
  const Vec3 nb = e3.cross(e2), nc = e1.cross(e3), nd = e2.cross(e1), na = -(nb + nc + nd);
  if (!(-e1.dot(nb) > 6.0 * min_volume)) return 1.0;
  const double la = 1.0 / na.norm(), lb = 1.0 / nb.norm(), lc = 1.0 / nc.norm(), ld = 1.0 / nd.norm();
  const double most = std::max({-na.dot(nb) * la * lb, -na.dot(nc) * la * lc, -na.dot(nd) * la * ld,
                                -nb.dot(nc) * lb * lc, -nb.dot(nd) * lb * ld, -nc.dot(nd) * lc * ld});
  return std::min(most, 1.0);
}

}  // namespace isochor
