#include <algorithm>
#include <array>
#include <cmath>

#include "core/collision/pair_tests.h"

namespace isochor {
namespace {

/// A box in the world: the columns of `axes` are its edges' directions.
struct OrientedBox {
  Vec3 center, half;
  Eigen::Matrix3d axes;

  explicit OrientedBox(const Placed<CollisionBox>& placed)
      : center(placed.pose.position),
        half(placed.shape.half_extents),
        axes(placed.pose.orientation.toRotationMatrix()) {}
  /// Half of the width along a direction.
  double reach(const Vec3& direction) const { return half.dot((axes.transpose() * direction).cwiseAbs()); }
};

struct SeparatingAxis {
  double separation = -1e300;
  Vec3 normal = Vec3::UnitY();   ///< from b to a
  int edge_a = -1, edge_b = -1;  ///< of two edges; else a face
  bool face_of_a = false;
  int axis = 0;  ///< of the face
};

double separation_along(const OrientedBox& a, const OrientedBox& b, const Vec3& direction) {
  return std::abs(direction.dot(a.center - b.center)) - a.reach(direction) - b.reach(direction);
}

Vec3 towards_a(const OrientedBox& a, const OrientedBox& b, const Vec3& direction) {
  return direction.dot(a.center - b.center) < 0.0 ? Vec3(-direction) : direction;
}

SeparatingAxis best_face(const OrientedBox& a, const OrientedBox& b) {
  SeparatingAxis best;
  for (const bool of_a : {false, true})
    for (int i = 0; i < 3; ++i) {
      const Vec3 direction = of_a ? a.axes.col(i) : b.axes.col(i);
      const double separation = separation_along(a, b, direction);
      // b's faces keep a tie, so that which face carries the contact does not flicker.
      if (separation <= best.separation + (of_a ? 1e-6 * (a.half.sum() + b.half.sum()) : 0.0)) continue;
      best = {separation, towards_a(a, b, direction), -1, -1, of_a, i};
    }
  return best;
}

SeparatingAxis best_edges(const OrientedBox& a, const OrientedBox& b) {
  SeparatingAxis best;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Vec3 cross = a.axes.col(i).cross(b.axes.col(j));
      const double sine = cross.norm();
      if (sine < 1e-4) continue;  // parallel: a face separates as well
      const Vec3 direction = cross / sine;
      const double separation = separation_along(a, b, direction);
      if (separation > best.separation) best = {separation, towards_a(a, b, direction), i, j, false, 0};
    }
  return best;
}

/// The point of the box's edge along `axis` that is farthest in the direction, and half of that edge.
std::array<Vec3, 2> extreme_edge(const OrientedBox& box, int axis, const Vec3& direction) {
  Vec3 middle = box.center;
  for (int i = 0; i < 3; ++i)
    if (i != axis)
      middle += (box.axes.col(i).dot(direction) >= 0.0 ? box.half[i] : -box.half[i]) * box.axes.col(i);
  return {middle, box.half[axis] * box.axes.col(axis)};
}

void add_edge_point(const OrientedBox& a, const OrientedBox& b, const SeparatingAxis& found, Manifold& out) {
  const auto [pa, da] = extreme_edge(a, found.edge_a, -found.normal);
  const auto [pb, db] = extreme_edge(b, found.edge_b, found.normal);
  // Closest points of two lines that are not parallel.
  const Vec3 r = pa - pb;
  const double aa = da.squaredNorm(), bb = db.squaredNorm(), ab = da.dot(db), det = aa * bb - ab * ab;
  const double s = std::clamp((ab * db.dot(r) - bb * da.dot(r)) / det, -1.0, 1.0);
  const double t = std::clamp((aa * db.dot(r) - ab * da.dot(r)) / det, -1.0, 1.0);
  ManifoldPoint point;
  point.core_a = pa + s * da;
  point.core_b = pb + t * db;
  point.normal = found.normal;
  out.add(point);
}

using Polygon = std::array<Vec3, 16>;

/// Sutherland & Hodgman 1974: what of the polygon lies where direction·x ≤ limit.
int clip(Polygon& polygon, int count, const Vec3& direction, double limit) {
  const Polygon source = polygon;
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 &p = source[static_cast<std::size_t>(i)],
               &q = source[static_cast<std::size_t>((i + 1) % count)];
    const double dp = direction.dot(p) - limit, dq = direction.dot(q) - limit;
    if (dp <= 0.0) polygon[static_cast<std::size_t>(kept++)] = p;
    if ((dp < 0.0 && dq > 0.0) || (dp > 0.0 && dq < 0.0))
      polygon[static_cast<std::size_t>(kept++)] = p + dp / (dp - dq) * (q - p);
  }
  return kept;
}

/// The face of the box that looks most against the direction.
Polygon incident_face(const OrientedBox& box, const Vec3& direction) {
  int axis = 0;
  (box.axes.transpose() * direction).cwiseAbs().maxCoeff(&axis);
  const double side = box.axes.col(axis).dot(direction) > 0.0 ? -1.0 : 1.0;
  const Vec3 u = box.half[(axis + 1) % 3] * box.axes.col((axis + 1) % 3);
  const Vec3 v = box.half[(axis + 2) % 3] * box.axes.col((axis + 2) % 3);
  const Vec3 center = box.center + side * box.half[axis] * box.axes.col(axis);
  Polygon polygon;
  polygon[0] = center + u + v;
  polygon[1] = center - u + v;
  polygon[2] = center - u - v;
  polygon[3] = center + u - v;
  return polygon;
}

/// Points of the incident box over the reference face; the normal points from reference to incident.
void add_face_points(const OrientedBox& reference, const OrientedBox& incident, int axis, const Vec3& normal,
                     double margin, Manifold& out) {
  Polygon polygon = incident_face(incident, normal);
  int count = 4;
  for (const int side : {(axis + 1) % 3, (axis + 2) % 3})
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 direction = sign * reference.axes.col(side);
      count = clip(polygon, count, direction, direction.dot(reference.center) + reference.half[side]);
    }
  const double face = normal.dot(reference.center) + reference.half[axis];
  for (int i = 0; i < count; ++i) {
    const Vec3& p = polygon[static_cast<std::size_t>(i)];
    const double gap = normal.dot(p) - face;
    if (gap >= margin) continue;
    ManifoldPoint point;
    point.core_a = p;
    point.core_b = p - gap * normal;
    point.normal = normal;
    point.owner = NormalOwner::b;
    out.add(point);
  }
}

}  // namespace

double collide_box_plane(const Placed<CollisionBox>& a, const Placed<CollisionPlane>& b, double margin,
                         Manifold& out) {
  double separation = 1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 signs(corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0);
    ManifoldPoint point;
    point.core_a = a.pose.to_world(signs.cwiseProduct(a.shape.half_extents));
    const SurfaceQuery q = b.query(point.core_a);
    separation = std::min(separation, q.distance);
    if (q.distance >= margin) continue;
    point.core_b = point.core_a - q.distance * q.normal;
    point.normal = q.normal;
    point.owner = NormalOwner::b;
    out.add(point);
  }
  return separation;
}

double collide_boxes(const Placed<CollisionBox>& a, const Placed<CollisionBox>& b, double margin,
                     Manifold& out) {
  const OrientedBox box_a(a), box_b(b);
  const SeparatingAxis face = best_face(box_a, box_b), edges = best_edges(box_a, box_b);
  const double separation = std::max(face.separation, edges.separation);
  if (separation >= margin) return separation;
  const double bias = 1e-6 * (box_a.half.sum() + box_b.half.sum());  // faces give the steadier contact
  if (edges.separation > face.separation + bias) {
    add_edge_point(box_a, box_b, edges, out);
  } else if (face.face_of_a) {
    add_face_points(box_a, box_b, face.axis, -face.normal, margin, out);
    out.flip();
  } else {
    add_face_points(box_b, box_a, face.axis, face.normal, margin, out);
  }
  out.reduce(4);
  return separation;
}

}  // namespace isochor
