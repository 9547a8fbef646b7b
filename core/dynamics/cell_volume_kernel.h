#pragma once

namespace isochor::detail {

/// A point whose coordinates are numbers or vectors of numbers, a lane a cell.
template <class T>
struct Point {
  T x, y, z;
};

template <class T>
inline Point<T> operator+(const Point<T>& a, const Point<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
inline Point<T> operator-(const Point<T>& a, const Point<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
inline Point<T> cross(const Point<T>& a, const Point<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
inline T dot(const Point<T>& a, const Point<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Corners of the central tet, as bits of Cell::corners; their antipodes (corner ^ 7) are the four apexes. Of
/// an odd cell, corner ^ 1.
inline constexpr int central_corners[4] = {0, 5, 3, 6};

/// Six times the volumes of the tets of an even cell with central corners c and apexes a, the central one
/// last. Of an odd cell they are negative.
template <class T>
struct SixfoldTets {
  T tet[5];
  T sum() const { return (tet[0] + tet[4]) + tet[1] + tet[2] + tet[3]; }
};
template <class T>
inline SixfoldTets<T> sixfold_tets(const Point<T> (&c)[4], const Point<T> (&a)[4]) {
  const Point<T> e1 = c[1] - c[0], e2 = c[2] - c[0], e3 = c[3] - c[0];
  const Point<T> n1 = cross(e3, e2), n2 = cross(e1, e3), n3 = cross(e2, e1);
  const Point<T> n0 = n1 + n2 + n3;  // −N₀
  return {{dot(a[1] - c[0], n1), dot(a[2] - c[0], n2), dot(a[3] - c[0], n3), -dot(a[0] - c[1], n0),
           -dot(e1, n1)}};
}

/// Six times ∂V/∂c and ∂V/∂a. The cross product of edge jk and the opposite apexes serves c_j and c_k both.
template <class T>
inline void sixfold_gradient(const Point<T> (&c)[4], const Point<T> (&a)[4], Point<T> (&gc)[4],
                             Point<T> (&ga)[4]) {
  const Point<T> e1 = c[1] - c[0], e2 = c[2] - c[0], e3 = c[3] - c[0];
  ga[1] = cross(e3, e2);
  ga[2] = cross(e1, e3);
  ga[3] = cross(e2, e1);
  const Point<T> sum = ga[1] + ga[2] + ga[3];
  ga[0] = Point<T>{-sum.x, -sum.y, -sum.z};
  const Point<T> x01 = cross(e1, a[2] - a[3]), x02 = cross(e2, a[3] - a[1]), x03 = cross(e3, a[1] - a[2]);
  const Point<T> x12 = cross(c[2] - c[1], a[0] - a[3]), x13 = cross(c[3] - c[1], a[2] - a[0]),
                 x23 = cross(c[3] - c[2], a[0] - a[1]);
  gc[0] = x01 + x02 + x03;
  gc[1] = x01 + x12 + x13;
  gc[2] = x02 + x12 + x23;
  gc[3] = x03 + x13 + x23;
}

}  // namespace isochor::detail
