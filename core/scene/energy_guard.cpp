#include <algorithm>
#include <cmath>

#include "core/dynamics/rigid_part.h"
#include "core/scene/substep.h"

namespace isochor {
namespace {

constexpr double swing = 0.02;  ///< of the energy of symplectic steps
constexpr double round_off = 1e-9;

/// v becomes v_rigid + s·(v − v_rigid), s so that the energy falls by the excess, or as far as that goes.
/// Returns by how much.
double damp_about(const RigidPart& motion, double excess, SoftBody& body) {
  const auto rigid = [&](std::size_t i) { return motion.velocity_at(body.positions.at(i)); };
  double energy = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i)
    energy += 0.5 * body.masses[i] * (body.velocities.at(i) - rigid(i)).squaredNorm();
  if (energy <= 0.0) return 0.0;
  const double taken = std::min(excess, energy), scale = std::sqrt(1.0 - taken / energy);
  for (std::size_t i = 0; i < body.size(); ++i)
    if (body.inverse_masses[i] > 0.0)
      body.velocities.set(i, rigid(i) + scale * (body.velocities.at(i) - rigid(i)));
  return taken;
}

bool is_held_or_dragged(const World& world, const SceneSoftBody& soft) {
  const auto moves = [](const PinnedParticle& pin) { return pin.rigid >= 0; };
  return !soft.attachments.empty() || std::ranges::any_of(soft.pins, moves) ||
         (world.grab && world.grab->body == soft.id);
}

bool is_free(const SceneSoftBody& soft) {
  return !soft.body.has_pins && (!soft.contacts || soft.contacts->empty());
}

bool is_driven(const World& world, const SceneSoftBody& soft) {
  return soft.touched || is_held_or_dragged(world, soft);
}

}  // namespace

std::optional<double> allowed_energy(const World& world, const SceneSoftBody& soft) {
  if (is_driven(world, soft)) return std::nullopt;
  const double work = soft.contacts ? soft.contacts->work(soft.body) : 0.0;
  return start_energy(soft.body, world.scene.gravity) + std::max(work, 0.0);
}

bool gains_energy(const Substep& step, const SceneSoftBody& soft) {
  const SoftBody& body = soft.body;
  const auto allowed = allowed_energy(step.world, soft);
  if (!allowed) return false;
  const Vec3& gravity = step.world.scene.gravity;
  double energy = spring_energy(body.springs, body.material, body.positions) + gravity_energy(body, gravity);
  double inside = spring_energy(body.springs, body.material, body.start_positions) +
                  0.5 * body.total_mass * (step.h * gravity).squaredNorm();
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) - body.start_positions.at(i);
    energy += 0.5 * body.masses[i] * moved.squaredNorm() / (step.h * step.h);
    inside += 0.5 * body.masses[i] * body.start_velocities.at(i).squaredNorm();
  }
  return energy > *allowed + 0.05 * inside;
}

bool keep_ledger(const World& world, SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  const double excess = total_energy(body, world.scene.gravity) - soft.energy_ledger;
  if (!(excess > 0.0)) return true;
  const RigidPart motion = body.has_pins ? RigidPart{} : rigid_part(body, body.positions, body.velocities);
  return damp_about(motion, excess, body) == excess;
}

void hold_collision_energy(World& world) {
  const Vec3& gravity = world.scene.gravity;
  double excess = 0.0, inside = 0.0;
  for (const SceneSoftBody& soft : world.soft) {
    if (!soft.touched) continue;
    if (is_held_or_dragged(world, soft)) return;
    const SoftBody& body = soft.body;
    const double work = soft.contacts ? soft.contacts->work(body) : 0.0;
    const double energy = total_energy(body, gravity);
    excess += energy - start_energy(body, gravity) - std::max(work, 0.0);
    inside += energy - gravity_energy(body, gravity);
  }
  if (!(excess > swing * inside)) return;
  for (SceneSoftBody& soft : world.soft)
    if (soft.touched && !soft.body.has_pins && excess > 0.0)
      excess -=
          damp_about(rigid_part(soft.body, soft.body.positions, soft.body.velocities), excess, soft.body);
}

bool hold_energy(const World& world, SceneSoftBody& soft) {
  const auto allowed = allowed_energy(world, soft);
  if (!allowed) return true;
  SoftBody& body = soft.body;
  const Vec3& gravity = world.scene.gravity;
  const double energy = total_energy(body, gravity), all = energy - *allowed;
  if (!(all > (soft.recovered ? 0.0 : swing * (energy - gravity_energy(body, gravity))))) return true;
  double excess = all;
  if (!body.has_pins) excess -= damp_about(rigid_part(body, body.positions, body.velocities), excess, body);
  if (!is_free(soft) && excess > 0.0) excess -= damp_about(RigidPart{}, excess, body);
  return excess <= round_off * all;
}

bool halt(const Substep& step, SceneSoftBody& soft) {
  if (soft.began_inverted || is_driven(step.world, soft) || !step.world.massive.empty() ||
      (soft.contacts && soft.contacts->on_the_move()))
    return false;
  SoftBody& body = soft.body;
  if (!soft.recovered) ++step.stats.recoveries;
  soft.recovered = true;
  restore_start(body);
  soft.inverted = soft.forces_valid = false;
  const RigidPart motion = is_free(soft) ? rigid_part(body, body.positions, body.velocities) : RigidPart{};
  for (std::size_t i = 0; i < body.size(); ++i)
    if (body.inverse_masses[i] > 0.0)
      body.velocities.set(i, 0.5 * (body.velocities.at(i) + motion.velocity_at(body.positions.at(i))));
  return true;
}

}  // namespace isochor
