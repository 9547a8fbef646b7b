#include "core/rigid/joint.h"

namespace isochor {

RigidJoint make_joint(const JointDesc& desc, const Pose& a, const Pose& b) {
  RigidJoint joint;
  joint.kind = desc.kind;
  joint.a = desc.a, joint.b = desc.b;
  joint.anchor_a = a.to_local(desc.anchor), joint.anchor_b = b.to_local(desc.anchor);
  joint.axis_a = a.orientation.conjugate() * desc.axis.normalized();
  joint.axis_b = b.orientation.conjugate() * desc.axis.normalized();
  joint.relative = a.orientation.conjugate() * b.orientation;
  return joint;
}

void append_joint_rows(const RigidJoint& joint, const Pose& a, const Pose& b, ConstraintSet& set) {
  // Both anchors agree up to the tolerance; one point for both keeps the angular momentum to round-off.
  const Vec3 point = 0.5 * (a.to_world(joint.anchor_a) + b.to_world(joint.anchor_b));
  const Vec3 axis = b.orientation * joint.axis_b, across = axis.unitOrthogonal();
  set.blocks.push_back({static_cast<int>(set.rows.size()), joint.rows(), false, 0.0});
  for (int i = 0; i < joint.rows(); ++i) {
    ConstraintRow row;
    row.a = joint.a, row.b = joint.b;
    RowDirections& on = row.impulse_on;
    if (i < 3) {
      on.linear = Vec3::Unit(i);
      on.angular_a = (point - a.position).cross(on.linear);
      on.angular_b = (point - b.position).cross(on.linear);
    } else {
      const Vec3 direction = i == 3 ? across : axis.cross(across);
      on.angular_a = on.angular_b = joint.kind == JointKind::fixed ? Vec3(Vec3::Unit(i - 3)) : direction;
    }
    row.rate_along = on;
    set.rows.push_back(row);
  }
}

void joint_errors(const RigidJoint& joint, const Pose& a, const Pose& b, std::span<ConstraintRow> rows,
                  std::span<double> errors) {
  const Vec3 on_a = a.to_world(joint.anchor_a), on_b = b.to_world(joint.anchor_b);
  Vec3 turned = Vec3::Zero();  // of a against b, for small angles
  if (joint.kind == JointKind::hinge)
    turned = (b.orientation * joint.axis_b).cross(a.orientation * joint.axis_a);
  if (joint.kind == JointKind::fixed)
    turned = rotation_log(a.orientation * joint.relative * b.orientation.conjugate());
  for (int i = 0; i < joint.rows(); ++i) {
    ConstraintRow& row = rows[static_cast<std::size_t>(i)];
    const RowDirections& on = row.impulse_on;
    errors[static_cast<std::size_t>(i)] = i < 3 ? on.linear.dot(on_a - on_b) : on.angular_a.dot(turned);
    if (i >= 3) continue;
    row.rate_along.angular_a = (on_a - a.position).cross(on.linear);
    row.rate_along.angular_b = (on_b - b.position).cross(on.linear);
  }
}

}  // namespace isochor
