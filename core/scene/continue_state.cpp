#include <algorithm>
#include <string>

#include "core/scene/build_world.h"

namespace isochor {
namespace {

const std::string& name_of(const World& world, int id) {
  return world.scene.bodies[static_cast<std::size_t>(id)].name;
}

void continue_body(SceneSoftBody& soft, const SceneSoftBody& before) {
  SoftBody& body = soft.body;
  body.positions = before.body.positions;
  body.velocities = before.body.velocities;
  for (std::size_t i = 0; i < body.size(); ++i)
    if (body.inverse_masses[i] == 0.0) body.velocities.set(i, Vec3::Zero());
  keep_start(body);
  soft.energy_ledger = before.energy_ledger;
  soft.kick_due = before.kick_due;
  soft.inverted = before.inverted;
  soft.started = before.started;
  soft.forces_valid = false;
}

}  // namespace

void continue_state(World& world, const World& before) {
  world.rigid.set_time(before.rigid.time());
  for (SceneSoftBody& soft : world.soft) {
    const auto same = std::ranges::find_if(before.soft, [&](const SceneSoftBody& other) {
      return name_of(before, other.id) == name_of(world, soft.id) && other.body.size() == soft.body.size();
    });
    if (same != before.soft.end()) continue_body(soft, *same);
  }
  for (int r = 0; r < world.rigid.size(); ++r)
    for (int other = 0; other < before.rigid.size(); ++other)
      if (before.rigid.dynamic(other) &&
          name_of(world, world.rigid_ids[r]) == name_of(before, before.rigid_ids[other]))
        world.rigid.set_state(r, before.rigid.state(other));
}

}  // namespace isochor
