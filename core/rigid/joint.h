#pragma once
#include <span>

#include "core/rigid/body_record.h"
#include "core/rigid/impulse_solver.h"

namespace isochor {

enum class JointKind { ball, hinge, fixed };

/// Two bodies held together at a point; a hinge leaves the rotation about its axis free.
struct JointDesc {
  JointKind kind = JointKind::ball;
  int a = 0, b = 0;
  Vec3 anchor = Vec3::Zero(), axis = Vec3::UnitY();  ///< world coordinates at the start
};

/// A joint in the frames of its bodies.
struct RigidJoint {
  JointKind kind = JointKind::ball;
  int a = 0, b = 0;
  Vec3 anchor_a, anchor_b, axis_a, axis_b;
  Eigen::Quaterniond relative;       ///< orientation of b seen from a, which a fixed joint keeps
  std::array<double, 6> impulses{};  ///< of the last step, to start from

  int rows() const { return kind == JointKind::ball ? 3 : kind == JointKind::hinge ? 5 : 6; }
};

RigidJoint make_joint(const JointDesc& desc, const Pose& a, const Pose& b);

/// The joint's rows at the poses, without residuals and impulses. The world's axes for the anchor; for a
/// hinge two directions across its axis.
void append_joint_rows(const RigidJoint& joint, const Pose& a, const Pose& b, ConstraintSet& set);

/// What is left of the joint's equations at the poses: metres between the anchors, radians between the axes,
/// along the rows' directions. Sets the directions in which these errors change there.
void joint_errors(const RigidJoint& joint, const Pose& a, const Pose& b, std::span<ConstraintRow> rows,
                  std::span<double> errors);

}  // namespace isochor
