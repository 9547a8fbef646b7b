#pragma once
#include <algorithm>
#include <cmath>

#include "core/common/types.h"

namespace isochor {

/// Outward normals of a tet's four faces, each as long as twice its face's area, and six times its volume.
/// e: the edges from its first vertex; without branches, so that a loop over tets becomes wide.
struct FaceNormals {
  struct Normal {
    double x, y, z;
  };
  Normal a, b, c, d;
  double six_volumes;

  FaceNormals(const double (&e1)[3], const double (&e2)[3], const double (&e3)[3])
      : b(cross(e3, e2)), c(cross(e1, e3)), d(cross(e2, e1)) {
    a = {-(b.x + c.x + d.x), -(b.y + c.y + d.y), -(b.z + c.z + d.z)};
    six_volumes = -dot({e1[0], e1[1], e1[2]}, b);
  }
  static double dot(const Normal& a, const Normal& b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
  static Normal cross(const double (&a)[3], const double (&b)[3]) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
};

/// Cosine of the smallest dihedral angle of a positive tet, that is the largest of −n_f·n_g over its pairs of
/// unit outward face normals. 1 when the volume is below min_volume.
inline double smallest_dihedral_cosine(const double (&e1)[3], const double (&e2)[3], const double (&e3)[3],
                                       double min_volume) {
  const FaceNormals n(e1, e2, e3);
  const auto dot = FaceNormals::dot;
  const double la = 1.0 / std::sqrt(dot(n.a, n.a)), lb = 1.0 / std::sqrt(dot(n.b, n.b)),
               lc = 1.0 / std::sqrt(dot(n.c, n.c)), ld = 1.0 / std::sqrt(dot(n.d, n.d));
  double most = -dot(n.a, n.b) * la * lb;
  most = std::max(most, -dot(n.a, n.c) * la * lc);
  most = std::max(most, -dot(n.a, n.d) * la * ld);
  most = std::max(most, -dot(n.b, n.c) * lb * lc);
  most = std::max(most, -dot(n.b, n.d) * lb * ld);
  most = std::max(most, -dot(n.c, n.d) * lc * ld);
  return n.six_volumes > 6.0 * min_volume ? std::min(most, 1.0) : 1.0;
}

/// Not negative where that cosine exceeds the positive one whose square is given: without a root or a
/// quotient, −n_f·n_g > cosine·|n_f|·|n_g| squared. Asks for edges of about one unit.
inline double excess_over_cosine(const double (&e1)[3], const double (&e2)[3], const double (&e3)[3],
                                 double squared_cosine, double min_volume) {
  const FaceNormals n(e1, e2, e3);
  const auto dot = FaceNormals::dot;
  const double a = squared_cosine * dot(n.a, n.a), b = squared_cosine * dot(n.b, n.b),
               c = squared_cosine * dot(n.c, n.c), bb = dot(n.b, n.b), cc = dot(n.c, n.c), dd = dot(n.d, n.d);
  const auto excess = [](double d, double limit) { return d * std::min(d, 0.0) - limit; };
  double most = excess(dot(n.a, n.b), a * bb);
  most = std::max(most, excess(dot(n.a, n.c), a * cc));
  most = std::max(most, excess(dot(n.a, n.d), a * dd));
  most = std::max(most, excess(dot(n.b, n.c), b * cc));
  most = std::max(most, excess(dot(n.b, n.d), b * dd));
  most = std::max(most, excess(dot(n.c, n.d), c * dd));
  return std::max(most, 6.0 * min_volume - n.six_volumes);
}

inline double smallest_dihedral_cosine(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                       double min_volume = 0.0) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  return smallest_dihedral_cosine({u.x(), u.y(), u.z()}, {v.x(), v.y(), v.z()}, {w.x(), w.y(), w.z()},
                                  min_volume);
}

}  // namespace isochor
