#pragma once
#include "core/common/disjoint_sets.h"
#include "core/dynamics/rigid_part.h"
#include "core/scene/world.h"

namespace isochor {

/// What the bodies of a group share.
struct GroupTraits {
  bool anchored = false;  ///< touches, or is pinned to, what has no mass
  int anchor = -1;        ///< the rigid body without mass that it touches; −1 where it is pinned in place
  bool between = false;   ///< has more than one anchor
  bool pinched = false;   ///< and they move differently
  bool unknown_work = false;  ///< the mouse, or moving bodies that are not its anchor, may move it
};

/// The bodies of a scene by what presses on what in a substep, directly or through others: deformable ones
/// and rigid ones with a mass. Those without a mass are the anchors of what touches them.
class ContactGroups {
 public:
  void find(const World& world);

  /// Any number that the members of a group have in common.
  int of_soft(std::size_t soft) const { return groups_.root(static_cast<int>(soft)); }
  int of_rigid(int rigid) const { return groups_.root(rigid_node(rigid)); }
  const GroupTraits& traits(int group) const { return traits_[static_cast<std::size_t>(group)]; }

 private:
  int rigid_node(int rigid) const { return static_cast<int>(soft_bodies_) + rigid; }
  void join_soft(const World& world);
  void join_rigid(const World& world);
  void anchor(const World& world, int node, int rigid);
  void anchor_all(const World& world);

  std::size_t soft_bodies_ = 0;
  DisjointSets groups_;  ///< of nodes: soft bodies, then rigid ones
  std::vector<GroupTraits> traits_;
  std::vector<std::pair<int, int>> pairs_;  ///< scratch
};

/// The motion of a body without mass in the substep, about where it is now; at rest for −1.
RigidPart anchor_motion(const World& world, int anchor);

}  // namespace isochor
