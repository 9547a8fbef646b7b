#include <algorithm>

#include "core/scene/substep.h"

namespace isochor {
namespace {

/// Bodies that do not agree by then go on with what they share where it is; the difference in momentum is
/// made up for at the end of the substep.
constexpr int most_turns = 8;
/// Times its load that what a rigid body carries weighs when it is to stay where it is.
constexpr double immovable = 1e9;

bool presses_on(const SceneSoftBody& soft, const MassiveBody& body) {
  return soft.contacts && soft.contacts->has_pushed(body.source);
}

/// Some rigid body with a mass is between two deformable ones, or was in the last substep.
bool any_shared(const World& world) {
  return std::ranges::any_of(world.massive, [&](const MassiveBody& body) {
    return std::ranges::count_if(world.soft, [&](const SceneSoftBody& s) { return presses_on(s, body); }) > 1;
  });
}

// While one body has its turn, the others' resistance counts as their mass. On its own, a plate of 1 kg
// between blocks of 40 kg would be pushed to and fro by either, a fortieth of the weight a turn.
void load_for(const Substep& step, SceneSoftBody& soft) {
  World& world = step.world;
  world.phases.run(Phase::rigid_bodies, [&] {
    for (const MassiveBody& body : world.massive) {
      double mass = 0.0;
      for (const SceneSoftBody& other : world.soft)
        if (&other != &soft && presses_on(other, body)) mass += other.body.total_mass;
      world.rigid.carry(body.source, step.held ? immovable * mass : mass);
    }
    list_massive(world);
    world.rigid.solve();
  });
}

}  // namespace

void list_massive(World& world) {
  world.massive.clear();
  for (int r = 0; r < world.rigid.size(); ++r) {
    if (!world.rigid.dynamic(r)) continue;
    const RigidBodyState& state = world.rigid.state(r);
    const Eigen::Matrix3d turn = state.pose.orientation.toRotationMatrix();
    world.massive.push_back({r, state.pose.position, 1.0 / state.inverse_mass,
                             turn * state.inertia * turn.transpose(), world.rigid.jointed(r)});
  }
}

void constrain_in_turns(const Substep& step) {
  World& world = step.world;
  bool shared = world.soft.size() > 1 && any_shared(world);
  for (SceneSoftBody& soft : world.soft) {
    if (shared) load_for(step, soft);
    constrain(step, soft);
  }
  const auto failed = [&] {
    return step.may_halve && std::ranges::any_of(world.soft, [](const SceneSoftBody& soft) {
             return soft.unbalanced || has_burst(soft.projection);
           });
  };
  shared |= world.soft.size() > 1 && any_shared(world);
  Substep turn = step;
  for (int turns = 1; shared && turns <= most_turns && !failed(); ++turns) {
    turn.held = turns == most_turns;
    bool changed = false;
    for (SceneSoftBody& soft : world.soft) {
      if (!soft.contacts) continue;
      load_for(turn, soft);
      soft.contacts->weigh(world.massive);
      changed |= constrain_again(turn, soft);
    }
    if (!changed) break;
  }
}

}  // namespace isochor
