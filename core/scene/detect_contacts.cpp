#include "core/scene/detect_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/collision/contact_response.h"

namespace isochor {
namespace {

/// Cells that a particle may move between the first round and a later one without being looked at again, and
/// how many times that it must have been away from all surfaces: distances to meshes are steeper than 1 in
/// places.
constexpr double stray = 0.25, safety = 4.0;
/// Normals closer than this (60°) are of the same side of a thin shape.
constexpr double same_side = 0.5;

Box swept_bounds(const SoftBody& body) {
  Box box;
  for (const auto i : body.surface_particles) {
    box.extend(body.start_positions.at(i));
    box.extend(body.positions.at(i));
  }
  return box;
}

/// Bounds of a shape in the world at a pose; an infinite shape has infinite ones.
Box world_bounds(const CollisionShape& shape, const Pose& pose) {
  const Box local = shape.bounds();
  if (!local.min.allFinite() || !local.max.allFinite()) {
    Box all;
    all.min.setConstant(-std::numeric_limits<double>::infinity());
    all.max.setConstant(std::numeric_limits<double>::infinity());
    return all;
  }
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p(corner & 1 ? local.max.x() : local.min.x(), corner & 2 ? local.max.y() : local.min.y(),
                 corner & 4 ? local.max.z() : local.min.z());
    box.extend(pose.to_world(p));
  }
  return box;
}

/// Bounds of a shape in the world on its way from one pose to another: those at both, and how far a corner's
/// arc rises above its chord.
Box swept_bounds(const CollisionShape& shape, const Pose& from, const Pose& to) {
  Box box = world_bounds(shape, from);
  const Box end = world_bounds(shape, to), local = shape.bounds();
  box.extend(end.min);
  box.extend(end.max);
  const double radius = local.min.cwiseAbs().cwiseMax(local.max.cwiseAbs()).norm();
  const double rise = 1.0 - std::cos(0.5 * from.orientation.angularDistance(to.orientation));
  if (!(rise > 0.0) || !std::isfinite(radius)) return box;
  box.min.array() -= rise * radius;
  box.max.array() += rise * radius;
  return box;
}

/// One rigid body over a substep, seen from the particles of a soft one.
class RigidSweep {
 public:
  RigidSweep(const SoftBody& body, const RigidWorld& world, int rigid, double h)
      : body_(body),
        shape_(world.shape(rigid)),
        bounds_(shape_.bounds()),
        from_(world.pose(rigid)),
        to_(world.predicted_pose(rigid)),
        swept_(swept_bounds(shape_, from_, to_)),
        slop_(contact_slop * body.cell_size),
        recovered_(recovery_speed * body.cell_size * h),
        h_(h),
        massive_(world.dynamic(rigid)) {
    plane_.source = rigid;
    plane_.friction = combined_friction(body.friction, world.friction(rigid));
    plane_.restitution = combined_restitution(body.restitution, world.restitution(rigid));
  }

  bool may_meet(const Box& particles) const { return overlaps(swept_, particles); }

  /// The particle may meet the body after having strayed.
  bool may_meet(std::int32_t i) const {
    const double reach = safety * stray * body_.cell_size;
    const Vec3 before = body_.start_positions.at(i), now = body_.positions.at(i);
    if (!overlaps(swept_, grown({before.cwiseMin(now), before.cwiseMax(now)}, reach))) return false;
    const Vec3 start = from_.to_local(before), end = to_.to_local(now);
    if (!overlaps(bounds_, grown({start.cwiseMin(end), start.cwiseMax(end)}, reach))) return false;
    return shape_.query(end).distance <= (end - start).norm() + reach;
  }

  bool massive() const { return massive_; }
  double slop() const { return slop_; }

  /// The plane of a particle that touches already, on the body's surface as it is now.
  ContactPlane follow(std::int32_t i, const ContactPlane& before) const {
    const Vec3 end = to_.to_local(body_.positions.at(i));
    const SurfaceQuery at_end = shape_.query(end);
    const Vec3 normal = to_.orientation * at_end.normal;
    if (normal.dot(before.normal) < same_side) return before;
    ContactPlane plane = plane_at(i, end - at_end.distance * at_end.normal, at_end.normal);
    leave_within(shape_.query(from_.to_local(body_.start_positions.at(i))).distance, plane);
    return plane;
  }

  /// The plane that the particle must stay in front of, when it is behind it by more than what is tolerated.
  bool meets(std::int32_t i, bool touching, double tolerated, ContactPlane& plane) const {
    const Vec3 before = body_.start_positions.at(i), now = body_.positions.at(i);
    if (!overlaps(swept_, {before.cwiseMin(now), before.cwiseMax(now)})) return false;
    const Vec3 start = from_.to_local(before), end = to_.to_local(now);
    if (!overlaps(bounds_, {start.cwiseMin(end), start.cwiseMax(end)})) return false;
    const SurfaceQuery at_end = shape_.query(end);
    const double path = (end - start).norm();
    if (at_end.distance > (touching ? -slop_ : path)) return false;
    Vec3 point, normal;
    double at_start = 0.0;
    if (!entry(start, end, at_end, point, normal, at_start)) return false;
    plane = plane_at(i, point, normal);
    leave_within(at_start, plane);
    return plane.offset - plane.normal.dot(body_.positions.at(i)) > tolerated;
  }

 private:
  ContactPlane plane_at(std::int32_t i, const Vec3& point, const Vec3& normal) const {
    ContactPlane plane = plane_;
    plane.normal = to_.orientation * normal;
    plane.offset = plane.normal.dot(to_.to_world(point));
    plane.surface_shift = to_.to_world(point) - from_.to_world(point);
    plane.approach = plane.normal.dot(body_.start_velocities.at(i) - plane.surface_shift / h_);
    return plane;
  }

  /// What began within the body by more than that does not come out at once.
  void leave_within(double distance_at_start, ContactPlane& plane) const {
    if (distance_at_start >= -slop_) return;
    plane.emerging = std::min(-distance_at_start, recovered_);
    plane.offset += distance_at_start + plane.emerging;
  }

  // Inside at the end, the nearest surface counts, unless it is the far side of what the path went into. From
  // the surface itself no path enters: what starts there and comes out behind is held where it started.
  bool entry(const Vec3& start, const Vec3& end, const SurfaceQuery& at_end, Vec3& point, Vec3& normal,
             double& distance_at_start) const {
    const auto take = [&](const Vec3& p, const Vec3& n) { point = p, normal = n; };
    const auto hit = shape_.sweep(start, end);
    if (!hit && at_end.distance >= 0.0) {
      const SurfaceQuery at_start = shape_.query(start);
      take(start, at_start.normal);
      return at_start.distance <= slop_ && normal.dot(end - start) < -slop_;
    }
    if (hit && (at_end.distance >= 0.0 || hit->normal.dot(at_end.normal) < same_side)) {
      take(start + hit->fraction * (end - start), hit->normal);
      return true;
    }
    take(end - at_end.distance * at_end.normal, at_end.normal);
    if (hit) return true;
    const SurfaceQuery at_start = shape_.query(start);
    distance_at_start = at_start.distance;
    if (at_start.normal.dot(at_end.normal) < same_side)
      take(start - at_start.distance * at_start.normal, at_start.normal);
    return true;
  }

  const SoftBody& body_;
  const CollisionShape& shape_;
  Box bounds_;  ///< of the shape, in its own frame
  Pose from_, to_;
  Box swept_;  ///< of the shape in the world, from one to the other
  double slop_, recovered_, h_;
  bool massive_;
  ContactPlane plane_;
};

/// True when the particle's contact with the body was added or moved.
bool detect_contact(const SoftBody& body, const RigidSweep& sweep, int rigid, std::int32_t i,
                    ParticleContacts& contacts) {
  if (!(body.inverse_masses[i] > 0.0) || contacts.attached(i)) return false;
  if (const ContactPlane* known = sweep.massive() ? contacts.plane_of(i, rigid) : nullptr)
    return contacts.renew_plane(body, i, sweep.follow(i, *known), sweep.slop());
  ContactPlane plane;
  const bool touching = contacts.touches(i);
  // A stiff body that gives way as a whole would let go and take hold in turn for less.
  const double tolerated = touching || contacts.with_body() ? sweep.slop() : 0.0;
  if (!sweep.meets(i, touching, tolerated, plane)) return false;
  contacts.set_plane(body, i, plane);
  return true;
}

bool have_strayed(const SoftBody& body, const Coordinates& seen) {
  const double farthest = stray * body.cell_size;
  for (std::size_t i = 0; i < body.size(); ++i)
    if (!((body.positions.at(i) - seen.at(i)).squaredNorm() <= farthest * farthest)) return true;
  return false;
}

}  // namespace

bool detect_contacts(const SoftBody& body, const RigidWorld& world, double h, ContactCandidates& candidates,
                     ParticleContacts& contacts) {
  const bool again = candidates.known && !have_strayed(body, candidates.seen);
  const bool first = !candidates.known;
  if (std::ssize(candidates.near) != world.size()) {
    candidates.near.resize(world.size());
    for (auto& particles : candidates.near) particles.reserve(body.surface_particles.size());
  }
  if (first) candidates.seen = body.positions;
  candidates.known = true;
  std::optional<Box> particles;
  bool found = false;
  for (int rigid = 0; rigid < world.size(); ++rigid) {
    std::vector<std::int32_t>& near = candidates.near[rigid];
    if (first) near.clear();
    const bool near_alone = again && !world.dynamic(rigid);
    if (near_alone && near.empty()) continue;
    const RigidSweep sweep(body, world, rigid, h);
    if (near_alone) {
      for (const auto i : near) found |= detect_contact(body, sweep, rigid, i, contacts);
      continue;
    }
    if (!particles) particles = grown(swept_bounds(body), first ? safety * stray * body.cell_size : 0.0);
    if (!sweep.may_meet(*particles)) continue;
    for (const auto i : body.surface_particles) {
      if (first && !sweep.massive()) {
        if (!sweep.may_meet(i)) continue;
        near.push_back(i);
      }
      found |= detect_contact(body, sweep, rigid, i, contacts);
    }
  }
  return found;
}

std::int64_t ContactCandidates::bytes() const {
  std::int64_t bytes = static_cast<std::int64_t>(3 * seen.size() * sizeof(double));
  for (const auto& particles : near)
    bytes += static_cast<std::int64_t>(particles.capacity() * sizeof(particles[0]));
  return bytes;
}

double deepest_penetration(const SoftBody& body, const RigidWorld& world, const ParticleContacts& contacts) {
  Box particles;
  for (const auto i : body.surface_particles) particles.extend(body.positions.at(i));
  double deepest = 0.0;
  for (int rigid = 0; rigid < world.size(); ++rigid) {
    if (!overlaps(world_bounds(world.shape(rigid), world.pose(rigid)), particles)) continue;
    for (const auto i : body.surface_particles) {
      if (!(body.inverse_masses[i] > 0.0) || contacts.attached(i)) continue;
      const Vec3 local = world.pose(rigid).to_local(body.positions.at(i));
      deepest = std::max(deepest, -world.shape(rigid).query(local).distance);
    }
  }
  return deepest;
}

}  // namespace isochor
