#include <algorithm>
#include <array>
#include <cmath>

#include "core/collision/pair_tests.h"

namespace isochor {
namespace {

/// Radius by which b's surface stands off the core that its distance is measured from.
double rounding(const CollisionShape& shape) {
  if (shape.type() == ShapeType::sphere) return static_cast<const CollisionSphere&>(shape).radius;
  if (shape.type() == ShapeType::capsule) return static_cast<const CollisionCapsule&>(shape).radius;
  return 0.0;
}

/// A ball around a core point of a against b's distance; returns the separation.
double add_ball(const Vec3& center, double radius, const PlacedShape& b, double margin, Manifold& out) {
  const SurfaceQuery q = b.shape.query(b.pose.to_local(center));
  const double gap = q.distance - radius;
  if (gap >= margin) return gap;
  const double round = rounding(b.shape);
  ManifoldPoint point;
  point.normal = b.pose.orientation * q.normal;
  point.core_a = center;
  point.core_b = center - (q.distance + round) * point.normal;
  point.radius_a = radius;
  point.radius_b = round;
  point.owner = round > 0.0 ? NormalOwner::world : NormalOwner::b;
  out.add(point);
  return gap;
}

struct Segment {
  Vec3 from, to;
  Vec3 at(double t) const { return from + t * (to - from); }
};

Segment axis_of(const Placed<CollisionCapsule>& capsule) {
  const Vec3 half = capsule.shape.half_height * (capsule.pose.orientation * Vec3::UnitY());
  return {capsule.pose.position - half, capsule.pose.position + half};
}

/// Parameters of the closest points of two segments [Ericson 2005, 5.1.9].
std::array<double, 2> closest_parameters(const Segment& a, const Segment& b) {
  const Vec3 da = a.to - a.from, db = b.to - b.from, r = a.from - b.from;
  const double aa = da.squaredNorm(), bb = db.squaredNorm(), ab = da.dot(db);
  const double ar = da.dot(r), br = db.dot(r), determinant = aa * bb - ab * ab;
  double s = determinant > 1e-12 * aa * bb ? std::clamp((ab * br - ar * bb) / determinant, 0.0, 1.0) : 0.5;
  const double t = std::clamp((ab * s + br) / bb, 0.0, 1.0);
  s = std::clamp((ab * t - ar) / aa, 0.0, 1.0);
  return {s, t};
}

double add_axis_pair(const Vec3& on_a, const Vec3& on_b, double radius_a, double radius_b, double margin,
                     Manifold& out) {
  const Vec3 offset = on_a - on_b;
  const double length = offset.norm(), gap = length - radius_a - radius_b;
  if (gap >= margin) return gap;
  ManifoldPoint point;
  point.core_a = on_a;
  point.core_b = on_b;
  point.normal = length > 0.0 ? Vec3(offset / length) : Vec3(Vec3::UnitY());
  point.radius_a = radius_a;
  point.radius_b = radius_b;
  out.add(point);
  return gap;
}

/// Where on the segment the box is closest: its distance is convex along a line, so bisect the slope.
double closest_to_box(const Segment& axis, const CollisionBox& box) {
  const Vec3 direction = axis.to - axis.from;
  const auto slope = [&](double t) { return box.query(axis.at(t)).normal.dot(direction); };
  if (slope(0.0) >= 0.0) return 0.0;
  if (slope(1.0) <= 0.0) return 1.0;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The part of the segment above the face that `axis` is normal to.
std::array<double, 2> clip_to_face(const Segment& s, const Vec3& half_extents, int axis) {
  double enter = 0.0, leave = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double step = s.to[i] - s.from[i];
    if (i == axis || step == 0.0) continue;
    const double t0 = (-half_extents[i] - s.from[i]) / step, t1 = (half_extents[i] - s.from[i]) / step;
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return {enter, leave};
}

}  // namespace

double collide_sphere(const Placed<CollisionSphere>& a, const PlacedShape& b, double margin, Manifold& out) {
  return add_ball(a.pose.position, a.shape.radius, b, margin, out);
}

double collide_capsule_plane(const Placed<CollisionCapsule>& a, const Placed<CollisionPlane>& b,
                             double margin, Manifold& out) {
  const Segment axis = axis_of(a);
  const PlacedShape plane{b.shape, b.pose};
  return std::min(add_ball(axis.from, a.shape.radius, plane, margin, out),
                  add_ball(axis.to, a.shape.radius, plane, margin, out));
}

double collide_capsules(const Placed<CollisionCapsule>& a, const Placed<CollisionCapsule>& b, double margin,
                        Manifold& out) {
  const Segment p = axis_of(a), q = axis_of(b);
  const Vec3 dp = p.to - p.from, dq = q.to - q.from;
  const double ra = a.shape.radius, rb = b.shape.radius;
  if (dp.cross(dq).norm() > 1e-3 * dp.norm() * dq.norm()) {
    const auto [s, t] = closest_parameters(p, q);
    return add_axis_pair(p.at(s), q.at(t), ra, rb, margin, out);
  }
  // Parallel: the ends of the stretch that they share, or the ends that face each other.
  const double t0 = (q.from - p.from).dot(dp) / dp.squaredNorm(),
               t1 = (q.to - p.from).dot(dp) / dp.squaredNorm();
  const double low = std::clamp(std::min(t0, t1), 0.0, 1.0), high = std::clamp(std::max(t0, t1), 0.0, 1.0);
  double separation = 1e300;
  for (const double s : {low, high}) {
    const double t = std::clamp((p.at(s) - q.from).dot(dq) / dq.squaredNorm(), 0.0, 1.0);
    separation = std::min(separation, add_axis_pair(p.at(s), q.at(t), ra, rb, margin, out));
    if (low == high) break;
  }
  return separation;
}

double collide_capsule_box(const Placed<CollisionCapsule>& a, const Placed<CollisionBox>& b, double margin,
                           Manifold& out) {
  const Segment world = axis_of(a), local{b.pose.to_local(world.from), b.pose.to_local(world.to)};
  const PlacedShape box{b.shape, b.pose};
  const double t = closest_to_box(local, b.shape);
  const SurfaceQuery closest = b.shape.query(local.at(t));
  add_ball(world.at(t), a.shape.radius, box, margin, out);
  int axis = 0;
  if (closest.normal.cwiseAbs().maxCoeff(&axis) > 1.0 - 1e-6)  // a face: it may carry the axis's ends as well
    for (const double end : clip_to_face(local, b.shape.half_extents, axis))
      if (std::abs(end - t) > 1e-3 && b.shape.query(local.at(end)).normal.dot(closest.normal) > 1.0 - 1e-6)
        add_ball(world.at(end), a.shape.radius, box, margin, out);
  return closest.distance - a.shape.radius;
}

}  // namespace isochor
