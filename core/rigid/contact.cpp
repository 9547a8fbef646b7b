#include "core/rigid/contact.h"

namespace isochor {

RigidContact make_contact(int a, int b, const ManifoldPoint& point, const Pose& pose_a, const Pose& pose_b) {
  RigidContact contact;
  contact.a = a, contact.b = b;
  contact.local_a = pose_a.to_local(point.core_a), contact.local_b = pose_b.to_local(point.core_b);
  contact.radius_a = point.radius_a, contact.radius_b = point.radius_b;
  contact.owner = point.owner;
  contact.normal = point.normal;
  if (point.owner == NormalOwner::a) contact.normal = pose_a.orientation.conjugate() * point.normal;
  if (point.owner == NormalOwner::b) contact.normal = pose_b.orientation.conjugate() * point.normal;
  return contact;
}

Vec3 contact_normal(const RigidContact& contact, const Pose& a, const Pose& b) {
  if (contact.owner == NormalOwner::a) return a.orientation * contact.normal;
  if (contact.owner == NormalOwner::b) return b.orientation * contact.normal;
  return contact.normal;
}

double contact_gap(const RigidContact& contact, const Pose& a, const Pose& b) {
  return contact_normal(contact, a, b).dot(a.to_world(contact.local_a) - b.to_world(contact.local_b)) -
         contact.radius_a - contact.radius_b;
}

void append_contact_rows(const RigidContact& contact, const Pose& a, const Pose& b, ConstraintSet& set) {
  const Vec3 normal = contact_normal(contact, a, b), tangent = normal.unitOrthogonal();
  Vec3 on_a = a.to_world(contact.local_a) - contact.radius_a * normal;
  Vec3 on_b = b.to_world(contact.local_b) + contact.radius_b * normal;
  // One point for both keeps the angular momentum to round-off. Where the bodies meet later in the step each
  // has its own arm, that at the meeting.
  if (!contact.ahead) on_a = on_b = 0.5 * (on_a + on_b);
  const Vec3 arm_a = on_a - a.position, arm_b = on_b - b.position;
  set.blocks.push_back({static_cast<int>(set.rows.size()), 3, true, contact.friction});
  for (const Vec3& direction : {normal, tangent, Vec3(normal.cross(tangent))}) {
    ConstraintRow row;
    row.a = contact.a, row.b = contact.b;
    row.impulse_on = row.rate_along = {direction, arm_a.cross(direction), arm_b.cross(direction)};
    set.rows.push_back(row);
  }
}

}  // namespace isochor
