#include "core/collision/primitives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/common/error.h"

namespace isochor {
namespace {

constexpr double infinite = 1e300;
constexpr double pi = std::numbers::pi;

/// Distance and direction from a point of the shape's skeleton; UnitY where the two coincide.
SurfaceQuery round_query(const Vec3& offset, double radius) {
  const double length = offset.norm();
  return {length - radius, length > 0.0 ? Vec3(offset / length) : Vec3(Vec3::UnitY())};
}

/// Smaller root of a·t² + 2b·t + c = 0 for c ≥ 0 and b < 0, without cancellation.
std::optional<double> first_root(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (b >= 0.0 || discriminant < 0.0) return std::nullopt;
  const double t = c / (-b + std::sqrt(discriminant));
  return t <= 1.0 ? std::optional(t) : std::nullopt;
}

std::optional<double> sphere_entry(const Vec3& from, const Vec3& step, double radius) {
  const double outside = std::max(0.0, from.norm() - radius);  // known to be outside, up to round-off
  return first_root(step.squaredNorm(), from.dot(step), outside * (from.norm() + radius));
}

/// Entry into the side of the capsule's cylinder, the caps left out.
std::optional<double> cylinder_entry(const Vec3& from, const Vec3& step, double radius, double half_height) {
  const Vec3 axial_free(1.0, 0.0, 1.0);
  const Vec3 f = from.cwiseProduct(axial_free), s = step.cwiseProduct(axial_free);
  if (f.norm() < radius && std::abs(from.y()) > half_height) return std::nullopt;  // enters through a cap
  const double outside = std::max(0.0, f.norm() - radius);
  const auto t = first_root(s.squaredNorm(), f.dot(s), outside * (f.norm() + radius));
  return t && std::abs(from.y() + *t * step.y()) <= half_height ? t : std::nullopt;
}

double sign(double x) {
  return std::signbit(x) ? -1.0 : 1.0;
}

/// Axis of the face closest to a point inside; the first of equals.
int closest_face(const Vec3& p, const Vec3& half_extents) {
  int axis = 0;
  (p.cwiseAbs() - half_extents).maxCoeff(&axis);
  return axis;
}

void require_positive(const char* what, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw Error(ErrorCode::invalid_argument, fmt::format("{} is {}, not a positive length", what, value),
              "give it in metres, above 0");
}

}  // namespace

std::optional<SweepHit> CollisionPlane::sweep(const Vec3& from, const Vec3& to) const {
  const double start = query(from).distance, end = query(to).distance;
  if (start < 0.0 || end >= start || end > 0.0) return std::nullopt;
  return SweepHit{start / (start - end), normal};
}

Box CollisionPlane::bounds() const {
  return {Vec3::Constant(-infinite), Vec3::Constant(infinite)};
}

SurfaceQuery CollisionSphere::query(const Vec3& point) const {
  return round_query(point, radius);
}

std::optional<SweepHit> CollisionSphere::sweep(const Vec3& from, const Vec3& to) const {
  if (query(from).distance < 0.0) return std::nullopt;
  const Vec3 step = to - from;
  const auto t = sphere_entry(from, step, radius);
  return t ? std::optional(SweepHit{*t, query(from + *t * step).normal}) : std::nullopt;
}

Box CollisionSphere::bounds() const {
  return {Vec3::Constant(-radius), Vec3::Constant(radius)};
}
double CollisionSphere::volume() const {
  return 4.0 / 3.0 * pi * radius * radius * radius;
}
Eigen::Matrix3d CollisionSphere::unit_inertia() const {
  return 0.4 * radius * radius * Eigen::Matrix3d::Identity();
}

SurfaceQuery CollisionBox::query(const Vec3& point) const {
  const Vec3 excess = point.cwiseAbs() - half_extents;
  if (excess.maxCoeff() > 0.0) {
    Vec3 offset = excess.cwiseMax(0.0);
    for (int i = 0; i < 3; ++i) offset[i] *= sign(point[i]);
    return round_query(offset, 0.0);
  }
  const int axis = closest_face(point, half_extents);
  return {excess[axis], sign(point[axis]) * Vec3::Unit(axis)};
}

std::optional<SweepHit> CollisionBox::sweep(const Vec3& from, const Vec3& to) const {
  if (query(from).distance < 0.0) return std::nullopt;
  const Vec3 step = to - from;
  double enter = -infinite, leave = infinite;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    if (step[i] == 0.0) {
      if (std::abs(from[i]) >= half_extents[i]) return std::nullopt;
      continue;
    }
    const double direction = sign(step[i]);
    const double near = (-direction * half_extents[i] - from[i]) / step[i];
    const double far = (direction * half_extents[i] - from[i]) / step[i];
    if (near > enter) enter = near, axis = i;
    leave = std::min(leave, far);
  }
  if (enter >= leave || enter < 0.0 || enter > 1.0) return std::nullopt;
  return SweepHit{enter, -sign(step[axis]) * Vec3::Unit(axis)};
}

Box CollisionBox::bounds() const {
  return {-half_extents, half_extents};
}
Eigen::Matrix3d CollisionBox::unit_inertia() const {
  const Vec3 squares = half_extents.cwiseAbs2();
  return ((Vec3::Constant(squares.sum()) - squares) / 3.0).asDiagonal();
}

SurfaceQuery CollisionCapsule::query(const Vec3& point) const {
  Vec3 offset = point;
  offset.y() -= std::clamp(point.y(), -half_height, half_height);
  const SurfaceQuery result = round_query(offset, radius);
  // On the axis of the cylinder every direction is as close except along it.
  return result.distance > -radius ? result : SurfaceQuery{-radius, Vec3::UnitX()};
}

std::optional<SweepHit> CollisionCapsule::sweep(const Vec3& from, const Vec3& to) const {
  if (query(from).distance < 0.0) return std::nullopt;
  const Vec3 step = to - from, cap = half_height * Vec3::UnitY();
  const std::array entries{cylinder_entry(from, step, radius, half_height),
                           sphere_entry(from - cap, step, radius), sphere_entry(from + cap, step, radius)};
  std::optional<double> first;
  for (const auto& entry : entries)
    if (entry && (!first || *entry < *first)) first = entry;
  return first ? std::optional(SweepHit{*first, query(from + *first * step).normal}) : std::nullopt;
}

Box CollisionCapsule::bounds() const {
  const Vec3 corner(radius, half_height + radius, radius);
  return {-corner, corner};
}

double CollisionCapsule::volume() const {
  return pi * radius * radius * (2.0 * half_height + 4.0 / 3.0 * radius);
}

/// A cylinder and two hemispheres, whose own centres lie 3/8 of the radius beyond the cylinder's ends.
Eigen::Matrix3d CollisionCapsule::unit_inertia() const {
  const double r = radius, h = half_height;
  const double cylinder = 2.0 * h / (2.0 * h + 4.0 / 3.0 * r), caps = 1.0 - cylinder;
  const double along = cylinder * 0.5 * r * r + caps * 0.4 * r * r;
  const double across = cylinder * (0.25 * r * r + h * h / 3.0) + caps * (0.4 * r * r + h * h + 0.75 * h * r);
  return Vec3(across, along, across).asDiagonal();
}

std::unique_ptr<CollisionShape> make_plane(const Vec3& normal, double offset) {
  const double length = normal.norm();
  if (!std::isfinite(length) || length == 0.0 || !std::isfinite(offset))
    throw Error(ErrorCode::invalid_argument, "a plane's normal has no direction or its offset is not finite",
                "give a normal such as [0, 1, 0]");
  return std::make_unique<CollisionPlane>(normal / length, offset);
}

std::unique_ptr<CollisionShape> make_sphere(double radius) {
  require_positive("the radius of a sphere", radius);
  return std::make_unique<CollisionSphere>(radius);
}

std::unique_ptr<CollisionShape> make_box(const Vec3& half_extents) {
  for (int i = 0; i < 3; ++i) require_positive("a half extent of a box", half_extents[i]);
  return std::make_unique<CollisionBox>(half_extents);
}

std::unique_ptr<CollisionShape> make_capsule(double radius, double half_height) {
  require_positive("the radius of a capsule", radius);
  require_positive("the half height of a capsule", half_height);
  return std::make_unique<CollisionCapsule>(radius, half_height);
}

}  // namespace isochor
