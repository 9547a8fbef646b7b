#include "core/scene/contact_groups.h"

#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

bool moves(const World& world, int rigid) {
  const RigidPart motion = anchor_motion(world, rigid);
  return !motion.velocity.isZero(0.0) || !motion.angular_velocity.isZero(0.0);
}

}  // namespace

void ContactGroups::find(const World& world) {
  soft_bodies_ = world.soft.size();
  const std::size_t nodes = soft_bodies_ + static_cast<std::size_t>(world.rigid.size());
  groups_.reset(nodes);
  traits_.assign(nodes, {});
  pairs_.clear();
  if (!world.massive.empty()) world.rigid.list_pairs(pairs_);
  join_soft(world);
  join_rigid(world);
  anchor_all(world);
}

void ContactGroups::join_soft(const World& world) {
  for (std::size_t s = 0; s < soft_bodies_; ++s) {
    if (!world.soft[s].contacts) continue;
    for (const ParticleContact& contact : world.soft[s].contacts->contacts())
      for (int k = 0; k < contact.planes; ++k)
        if (world.rigid.dynamic(contact.plane[k].source))
          groups_.join(static_cast<int>(s), rigid_node(contact.plane[k].source));
    // Contacts released at last have pushed it all the same: of 1e90 kg m/s and back, round-off leaves 1e75.
    for (const MassiveBody& body : world.massive)
      if (world.soft[s].contacts->has_pushed(body.source))
        groups_.join(static_cast<int>(s), rigid_node(body.source));
  }
  if (!world.surfaces) return;
  for (const SurfaceContact& contact : world.surfaces->contacts().contacts())
    groups_.join(contact.owner, contact.other);
}

void ContactGroups::join_rigid(const World& world) {
  for (const auto& [a, b] : pairs_)
    if (world.rigid.dynamic(a) && world.rigid.dynamic(b)) groups_.join(rigid_node(a), rigid_node(b));
}

void ContactGroups::anchor(const World& world, int node, int rigid) {
  GroupTraits& group = traits_[static_cast<std::size_t>(groups_.root(node))];
  if (!group.anchored)
    group.anchored = true, group.anchor = rigid;
  else if (group.anchor != rigid)
    group.between = true, group.pinched |= moves(world, group.anchor) || moves(world, rigid);
}

void ContactGroups::anchor_all(const World& world) {
  for (std::size_t s = 0; s < soft_bodies_; ++s) {
    const SceneSoftBody& soft = world.soft[s];
    const int node = static_cast<int>(s);
    GroupTraits& group = traits_[static_cast<std::size_t>(of_soft(s))];
    group.unknown_work |= world.grab && world.grab->body == soft.id;
    for (const PinnedParticle& pin : soft.pins) anchor(world, node, pin.rigid);
    if (!soft.contacts) continue;
    for (const ParticleContact& contact : soft.contacts->contacts())
      for (int k = 0; k < contact.planes; ++k)
        if (!world.rigid.dynamic(contact.plane[k].source)) anchor(world, node, contact.plane[k].source);
  }
  for (const auto& [a, b] : pairs_) {
    if (world.rigid.dynamic(a) && !world.rigid.dynamic(b)) anchor(world, rigid_node(a), b);
    if (world.rigid.dynamic(b) && !world.rigid.dynamic(a)) anchor(world, rigid_node(b), a);
  }
}

// Σ e_k × (ω × e_k) = 2ω.
RigidPart anchor_motion(const World& world, int anchor) {
  RigidPart motion;
  if (anchor < 0) return motion;
  motion.center = world.rigid.pose(anchor).position;
  motion.velocity = world.rigid.velocity_at(anchor, motion.center);
  for (int k = 0; k < 3; ++k) {
    const Vec3 arm = Vec3::Unit(k);
    motion.angular_velocity +=
        0.5 * arm.cross(world.rigid.velocity_at(anchor, motion.center + arm) - motion.velocity);
  }
  return motion;
}

}  // namespace isochor
