#pragma once
#include <algorithm>
#include <cmath>

#include "core/common/types.h"

namespace isochor {

/// Cosine of the smallest dihedral angle of a positive tet, that is the largest of −n_f·n_g over its pairs of
/// unit outward face normals. 1 when the volume is below min_volume. e: the edges from its first vertex;
/// without branches, so that a loop over tets becomes wide.
inline double smallest_dihedral_cosine(const double (&e1)[3], const double (&e2)[3], const double (&e3)[3],
                                       double min_volume) {
  struct Normal {
    double x, y, z;
  };
  const auto dot = [](const Normal& a, const Normal& b) { return a.x * b.x + (a.y * b.y + a.z * b.z); };
  const auto cross = [](const double(&a)[3], const double(&b)[3]) {
    return Normal{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Normal nb = cross(e3, e2), nc = cross(e1, e3), nd = cross(e2, e1),
               na{-(nb.x + nc.x + nd.x), -(nb.y + nc.y + nd.y), -(nb.z + nc.z + nd.z)};
  const double la = 1.0 / std::sqrt(dot(na, na)), lb = 1.0 / std::sqrt(dot(nb, nb)),
               lc = 1.0 / std::sqrt(dot(nc, nc)), ld = 1.0 / std::sqrt(dot(nd, nd));
  double most = -dot(na, nb) * la * lb;
  most = std::max(most, -dot(na, nc) * la * lc);
  most = std::max(most, -dot(na, nd) * la * ld);
  most = std::max(most, -dot(nb, nc) * lb * lc);
  most = std::max(most, -dot(nb, nd) * lb * ld);
  most = std::max(most, -dot(nc, nd) * lc * ld);
  const double six_volumes = -dot({e1[0], e1[1], e1[2]}, nb);
  return six_volumes > 6.0 * min_volume ? std::min(most, 1.0) : 1.0;
}

inline double smallest_dihedral_cosine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                       double min_volume = 0.0) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  return smallest_dihedral_cosine({u.x(), u.y(), u.z()}, {v.x(), v.y(), v.z()}, {w.x(), w.y(), w.z()},
                                  min_volume);
}

}  // namespace isochor
