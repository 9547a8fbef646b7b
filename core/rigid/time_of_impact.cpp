#include "core/rigid/time_of_impact.h"

#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

constexpr int max_advances = 200;
constexpr double near = 1e-3, touching = 1e-9;  // of the smaller body's reach

double reach_under_rotation(const BodyRecord& body, double farthest) {
  return body.shape->type() == ShapeType::sphere ? 0.0 : std::min(body.reach, farthest);
}

/// Rate at which the closest points approach; not positive when they part.
double closing_speed(const BodyPath& a, const BodyPath& b, double t, const Impact& impact) {
  const auto points = impact.manifold.points();
  const auto closest = std::min_element(points.begin(), points.end(),
                                        [](const auto& p, const auto& q) { return p.gap() < q.gap(); });
  if (closest == points.end()) return 0.0;
  const Vec3 point = closest->point();
  const Vec3 va = a.velocity(t) + a.body.angular_velocity().cross(point - impact.pose_a.position);
  const Vec3 vb = b.velocity(t) + b.body.angular_velocity().cross(point - impact.pose_b.position);
  return closest->normal.dot(vb - va);
}

}  // namespace

Pose BodyPath::at(double t) const {
  const Vec3 fall = body.dynamic() ? Vec3(0.5 * t * t * gravity) : Vec3(Vec3::Zero());
  const Vec3 position = body.state.pose.position + t * body.velocity() + fall;
  if (body.dynamic()) return {position, rotate_freely(body.state, t)};
  return {position, (rotation_exp(t * body.motion_spin) * body.state.pose.orientation).normalized()};
}

Vec3 BodyPath::velocity(double t) const {
  return body.dynamic() ? Vec3(body.velocity() + t * gravity) : body.velocity();
}

double approach_bound(const BodyPath& a, const BodyPath& b, double h) {
  const Vec3 start = a.velocity(0.0) - b.velocity(0.0), end = a.velocity(h) - b.velocity(h);
  const double linear = std::max(start.norm(), end.norm());
  const double apart = (a.body.state.pose.position - b.body.state.pose.position).norm() + linear * h;
  return linear + a.body.angular_velocity().norm() * reach_under_rotation(a.body, apart + b.body.reach) +
         b.body.angular_velocity().norm() * reach_under_rotation(b.body, apart + a.body.reach);
}

bool find_impact(const BodyPath& a, const BodyPath& b, const ImpactSearch& search, Impact& impact) {
  const double h = search.until, scale = std::min(a.body.reach, b.body.reach),
               bound = approach_bound(a, b, h);
  if (bound == 0.0) return false;
  // Bodies that part meet again after some part of a turn.
  const double spin = a.body.angular_velocity().norm() + b.body.angular_velocity().norm();
  const double part = std::clamp(0.05 / std::max(spin, 1e-9), 1e-4 * h, 0.05 * h);
  impact.time = search.from;
  for (int i = 0; i < max_advances && impact.time <= h; ++i) {
    impact.pose_a = a.at(impact.time), impact.pose_b = b.at(impact.time);
    const double gap = collide({*a.body.shape, impact.pose_a}, {*b.body.shape, impact.pose_b},
                               std::max(near * scale, (h - impact.time) * bound), impact.manifold);
    const double speed = gap < near * scale ? closing_speed(a, b, impact.time, impact) : 0.0;
    const bool closing = speed > search.least_speed;
    if (gap <= touching * scale && closing) return true;
    // Far, no step may be longer than the bound allows.
    const double least = closing ? gap / speed : gap < near * scale ? part : 0.0;
    impact.time += std::max(least, gap / bound);
  }
  return false;
}

}  // namespace isochor
