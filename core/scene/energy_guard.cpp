#include "core/scene/energy_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/collision/contact_response.h"
#include "core/dynamics/volume_elements.h"
#include "core/scene/detect_contacts.h"
#include "core/scene/metrics.h"

namespace isochor {
namespace {

constexpr double swing = 0.02;  ///< of the energy of symplectic steps
constexpr double round_off = 1e-9;
/// What a group is taken back for though surfaces go on, or it has been often: energy from nowhere, as much
/// as it had. Tets that stay inverted are no reason, nor is less room than the volume, where springs have to
/// give.
constexpr double blown_up = 1.0;
/// Then next to nothing is left of its motion, and the same would fail again for ever.
constexpr int most_halts_in_a_row = 128;
constexpr double kept = 0.5;  ///< of a halted group's inner motion

double energy_about(const RigidPart& motion, const SoftBody& body) {
  double energy = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i)
    energy += 0.5 * body.masses[i] *
              (body.velocities.at(i) - motion.velocity_at(body.positions.at(i))).squaredNorm();
  return energy;
}

Eigen::Matrix3d world_inertia(const RigidBodyState& state) {
  const Eigen::Matrix3d turn = state.pose.orientation.toRotationMatrix();
  return turn * state.inertia * turn.transpose();
}

double energy_about(const RigidPart& motion, const RigidBodyState& state) {
  const Vec3 v = state.velocity - motion.velocity_at(state.pose.position);
  const Vec3 spin = state.angular_velocity() - motion.angular_velocity;
  return 0.5 * v.squaredNorm() / state.inverse_mass + 0.5 * spin.dot(world_inertia(state) * spin);
}

/// v becomes v_motion + s·(v − v_motion).
void scale_about(const RigidPart& motion, double scale, SoftBody& body) {
  for (std::size_t i = 0; i < body.size(); ++i) {
    if (!(body.inverse_masses[i] > 0.0)) continue;
    const Vec3 common = motion.velocity_at(body.positions.at(i));
    body.velocities.set(i, common + scale * (body.velocities.at(i) - common));
  }
}

void scale_about(const RigidPart& motion, double scale, RigidBodyState& state) {
  const Vec3 common = motion.velocity_at(state.pose.position);
  state.velocity = common + scale * (state.velocity - common);
  const Vec3 turning = world_inertia(state) * motion.angular_velocity;
  state.angular_momentum = turning + scale * (state.angular_momentum - turning);
}

/// s so that s² of the energy is left when the excess is taken from it, as far as that goes.
double scale_for(double excess, double energy) {
  return energy > 0.0 ? std::sqrt(1.0 - std::min(excess, energy) / energy) : 1.0;
}

/// Of all springs at a strain of a twentieth.
double energy_when_strained(const SoftBody& body) {
  const double stretch = 0.05 * body.cell_size, cells = static_cast<double>(body.mesh->cells.size());
  return 0.5 * cells * (12.0 * body.material.edge + 4.0 * body.material.diagonal) * stretch * stretch;
}

/// A cell has lost or gained as much as it holds, which it had at the start.
bool is_torn(const SoftBody& body) {
  const VolumeElements cells(*body.mesh, false);
  for (std::int64_t c = 0; c < cells.count(); ++c) {
    const auto keeps = [&](const Coordinates& x) {
      return std::abs(cells.volume(c, x) - body.rest_volumes[c]) <= body.rest_volumes[c];
    };
    if (!keeps(body.positions) && keeps(body.start_positions)) return true;
  }
  return false;
}

double damp_about(const RigidPart& motion, double excess, SoftBody& body) {
  const double energy = energy_about(motion, body);
  if (!(energy > 0.0)) return 0.0;
  scale_about(motion, scale_for(excess, energy), body);
  return std::min(excess, energy);
}

Eigen::Matrix3d inertia_about(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
}

}  // namespace

void EnergyGuard::Sums::add_soft(const SoftBody& body, const Coordinates& x, const Coordinates& v) {
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 p = body.masses[i] * v.at(i);
    kinetic += 0.5 * p.dot(v.at(i));
    momentum += p;
    center += body.masses[i] * x.at(i);
  }
  mass += body.total_mass;
}

void EnergyGuard::Sums::add_turning(const SoftBody& body, const Coordinates& x, const Coordinates& v) {
  for (std::size_t i = 0; i < body.size(); ++i) {
    angular_momentum += body.masses[i] * x.at(i).cross(v.at(i));
    inertia += inertia_about(body.masses[i], x.at(i));
  }
}

void EnergyGuard::Sums::add_rigid(const RigidBodyState& state) {
  const double m = 1.0 / state.inverse_mass;
  mass += m;
  kinetic += kinetic_energy(state);
  momentum += m * state.velocity;
  center += m * state.pose.position;
  angular_momentum += state.angular_momentum + m * state.pose.position.cross(state.velocity);
  inertia += world_inertia(state) + inertia_about(m, state.pose.position);
}

RigidPart EnergyGuard::Sums::common_motion() const {
  const Vec3 c = center / mass, v = momentum / mass;
  return {c, v, spin_of(inertia - inertia_about(mass, c), angular_momentum - c.cross(momentum))};
}

template <class Visit>
void EnergyGuard::for_soft(int group, const Visit& visit) const {
  for (std::size_t s = 0; s < world_.soft.size(); ++s)
    if (groups_.of_soft(s) == group) visit(world_.soft[s]);
}

template <class Visit>
void EnergyGuard::for_rigid(int group, const Visit& visit) const {
  for (const MassiveBody& body : world_.massive)
    if (groups_.of_rigid(body.source) == group) visit(body.source);
}

void EnergyGuard::begin() {
  rigid_start_.clear();
  for (int r = 0; r < world_.rigid.size(); ++r) rigid_start_.push_back(world_.rigid.state(r));
}

bool EnergyGuard::is_in_contact(const SceneSoftBody& soft) const {
  if (soft.touched || (soft.contacts && !soft.contacts->empty())) return true;
  return soft.contacts && std::ranges::any_of(world_.massive, [&](const MassiveBody& body) {
           return soft.contacts->has_pushed(body.source);
         });
}

double EnergyGuard::emerging_speed(int group) const {
  double speed = 0.0;
  for_soft(group, [&](const SceneSoftBody& soft) {
    if (soft.contacts && soft.contacts->emerging())
      speed = std::max(speed, recovery_speed * soft.body.cell_size);
  });
  return speed;
}

// Of implicit steps the reactions are not known: theirs is only bounded by the speed.
double EnergyGuard::emerging_work(int group) const {
  double work = 0.0;
  for_soft(group, [&](const SceneSoftBody& soft) {
    if (soft.implicit) work = std::numeric_limits<double>::infinity();
    if (soft.contacts && soft.contacts->emerging()) work += soft.contacts->emerging_work(soft.body);
  });
  return work;
}

bool EnergyGuard::can_halt(std::size_t soft) const {
  return can_halt_group(groups_.of_soft(soft));
}

bool EnergyGuard::can_halt_group(int group) const {
  const GroupTraits& traits = groups_.traits(group);
  bool helps = true;
  for_soft(group, [&](const SceneSoftBody& soft) {
    helps &= !soft.began_inverted && soft.halts_in_a_row < most_halts_in_a_row;
  });
  return helps && !traits.pinched && !traits.unknown_work;
}

/// Between what presses, where springs are too weak to tell. Once it has none, whatever turns tets over,
/// though it keeps their volume, is a way out that there is not.
bool EnergyGuard::has_no_room(const Substep& step, int group, bool feasible) const {
  const GroupTraits& traits = groups_.traits(group);
  bool result = false;
  if (!traits.between) return result;
  for_soft(group, [&](const SceneSoftBody& soft) {
    const bool turned = soft.inverted && !soft.began_inverted;
    const bool thrown = throws_a_particle(step, soft.body);
    if (feasible)
      result |= traits.pinched && ((turned && soft.halts_in_a_row > 0) || (soft.inverted && thrown));
    else
      result |= thrown || (traits.pinched && (turned || is_torn(soft.body)));
  });
  return result;
}

void EnergyGuard::hold(const Substep& step) {
  for (std::size_t s = 0; s < world_.soft.size(); ++s) {
    const int group = groups_.of_soft(s);
    bool first = true, judged = false, useless = false, feasible = true, burst = false;
    for (std::size_t before = 0; before < s; ++before) first &= groups_.of_soft(before) != group;
    if (!first) continue;
    for_soft(group, [&](const SceneSoftBody& soft) {
      judged |= !soft.finished && (soft.recovered || is_in_contact(soft));
      useless |= soft.inverted || soft.entered;
      feasible &= soft.projection.converged;
      burst |= has_burst(soft.projection) && is_torn(soft.body);
    });
    if (!judged && !useless) {
      for_soft(group, [](SceneSoftBody& soft) { soft.spring_energy.reset(), soft.gained = 0.0; });
      continue;
    }
    const bool may_halt = can_halt_group(group);
    const bool lost = burst || has_no_room(step, group, feasible);
    const double left = (useless && may_halt) || lost ? 0.0 : judge(step, group);
    if (lost || std::isinf(left) || (may_halt ? useless || left > round_off : feasible && left > blown_up))
      halt(step, group);
    else
      for_soft(group, [](SceneSoftBody& soft) { soft.halts_in_a_row = 0; });
  }
}

EnergyGuard::Sums EnergyGuard::sum(int group, At when, bool turning) const {
  Sums sums;
  for_soft(group, [&](const SceneSoftBody& soft) {
    const SoftBody& body = soft.body;
    const Coordinates& x = when == At::start ? body.start_positions : body.positions;
    const Coordinates& v = when == At::start ? body.start_velocities : body.velocities;
    sums.add_soft(body, x, v);
    if (turning) sums.add_turning(body, x, v);
  });
  for_rigid(group, [&](int r) {
    sums.add_rigid(when == At::start ? rigid_start_[static_cast<std::size_t>(r)] : world_.rigid.state(r));
  });
  sums.potential = -world_.scene.gravity.dot(sums.center);
  return sums;
}

/// That of the end is kept for the next substep.
double EnergyGuard::spring_energy_at(SceneSoftBody& soft, At when) const {
  const SoftBody& body = soft.body;
  if (when == At::start)
    return soft.spring_energy ? *soft.spring_energy
                              : spring_energy(body.springs, body.material, body.start_positions);
  soft.spring_energy = spring_energy(body.springs, body.material, body.positions);
  return *soft.spring_energy;
}

/// Its impulse by its velocity: what it does to the momenta, but for gravity's share.
double EnergyGuard::work_of_anchor(const Substep& step, int group, const Sums& start, const Sums& end) const {
  const GroupTraits& traits = groups_.traits(group);
  if (traits.pinched) {
    double work = 0.0;
    for_soft(group, [&](SceneSoftBody& soft) {
      if (!soft.contacts) return;
      // What lifts have displaced counts as force on the contacts, and is none.
      if (!soft.recovered) soft.contact_power = std::max(soft.contacts->work(soft.body), 0.0) / step.h;
      work += step.h * soft.contact_power;
    });
    return work;
  }
  if (traits.anchor < 0 || world_.rigid.immobile(traits.anchor)) return 0.0;
  const RigidPart motion = anchor_motion(world_, traits.anchor);
  const Vec3 weight = step.h * world_.scene.gravity;
  const Vec3 impulse = end.momentum - start.momentum - start.mass * weight;
  const Vec3 moment = end.angular_momentum - start.angular_momentum - start.center.cross(weight);
  return impulse.dot(motion.velocity) + (moment - motion.center.cross(impulse)).dot(motion.angular_velocity);
}

/// What could not be taken of the excess, that of springs that alone hold more than the group may have, over
/// what it had inside or would have at a strain of a twentieth. Infinite where nothing is finite.
double EnergyGuard::judge(const Substep& step, int group) {
  const GroupTraits& traits = groups_.traits(group);
  if (traits.unknown_work) return 0.0;
  const bool turning = traits.anchor >= 0 && !world_.rigid.immobile(traits.anchor);
  const Sums start = sum(group, At::start, turning), end = sum(group, At::end, turning);
  double excess =
      end.kinetic + end.potential - start.kinetic - start.potential - work_of_anchor(step, group, start, end);
  double inside = 0.0, gained = 0.0, springs_at_start = 0.0, strained = 0.0;
  bool recovered = false;
  for_soft(group, [&](SceneSoftBody& soft) {
    springs_at_start += spring_energy_at(soft, At::start);
    strained += energy_when_strained(soft.body);
    const double springs = spring_energy_at(soft, At::end);
    excess += springs;
    inside += springs;
    gained += soft.gained;
    recovered |= soft.recovered;
    soft.gained = 0.0;
  });
  excess -= springs_at_start;
  if (const double v = emerging_speed(group); v > 0.0)
    excess -= std::min(emerging_work(group),
                       std::max(0.5 * end.mass * v * v - start.kinetic, 0.0) +
                           std::max(inside + end.potential - springs_at_start - start.potential, 0.0));
  if (!std::isfinite(excess)) return std::numeric_limits<double>::infinity();
  const Vec3 v =
      traits.anchored ? anchor_motion(world_, traits.anchor).velocity : Vec3(end.momentum / end.mass);
  inside += end.kinetic - end.momentum.dot(v) +
            0.5 * end.mass * (v.squaredNorm() + (step.h * world_.scene.gravity).squaredNorm());
  // Of what it would have without the excess: a light ball may not swing by what has thrown it out of a cube.
  const double limit = recovered ? 0.0 : swing * std::max(inside - std::max(excess, 0.0), 0.0);
  gained = std::max(0.0, gained + excess);
  const double all = gained - limit;
  for_soft(group, [&](SceneSoftBody& soft) { soft.gained = std::exchange(gained, 0.0); });
  if (all <= 0.0) return 0.0;
  for_soft(group, [&](SceneSoftBody& soft) { soft.gained = std::min(soft.gained, limit); });
  return slow_down(group, all) / (springs_at_start + start.kinetic + strained);
}

/// Takes the excess from the group's motion. Returns what it has not enough for.
double EnergyGuard::slow_down(int group, double excess) {
  const GroupTraits& traits = groups_.traits(group);
  const double all = excess;
  for_soft(group, [&](SceneSoftBody& soft) {
    SoftBody& body = soft.body;
    if (!body.has_pins && excess > 0.0)
      excess -= damp_about(rigid_part(body, body.positions, body.velocities), excess, body);
  });
  if (excess > round_off * all)
    excess -= slow_down_about(traits.anchored ? anchor_motion(world_, traits.pinched ? -1 : traits.anchor)
                                              : sum(group, At::end, true).common_motion(),
                              group, excess);
  return excess <= round_off * all ? 0.0 : excess;
}

double EnergyGuard::slow_down_about(const RigidPart& motion, int group, double excess) {
  double energy = 0.0;
  for_soft(group, [&](const SceneSoftBody& soft) { energy += energy_about(motion, soft.body); });
  for_rigid(group, [&](int r) { energy += energy_about(motion, world_.rigid.state(r)); });
  if (!(energy > 0.0)) return 0.0;
  const double scale = scale_for(excess, energy);
  for_soft(group, [&](SceneSoftBody& soft) { scale_about(motion, scale, soft.body); });
  for_rigid(group, [&](int r) {
    RigidBodyState state = world_.rigid.state(r);
    scale_about(motion, scale, state);
    world_.rigid.set_state(r, state);
  });
  return std::min(excess, energy);
}

EnergyGuard::Carriage EnergyGuard::carriage_of(int anchor) const {
  Carriage carriage;
  if (anchor < 0) return carriage;
  carriage.from = rigid_start_[static_cast<std::size_t>(anchor)].pose;
  carriage.to = world_.rigid.pose(anchor);
  carriage.motion = anchor_motion(world_, anchor);
  carriage.motion.center = carriage.from.position;
  return carriage;
}

// A free group moves by the path of its centre, without turning, so that its energy, momentum and angular
// momentum are those of the start exactly; an anchored one with its anchor.
EnergyGuard::Carriage EnergyGuard::own_carriage(const Substep& step, int group) const {
  const GroupTraits& traits = groups_.traits(group);
  if (traits.anchored) return carriage_of(traits.pinched ? -1 : traits.anchor);
  Carriage carriage;
  carriage.gained = step.h * world_.scene.gravity;
  carriage.motion = sum(group, At::start, true).common_motion();
  carriage.to.position = step.h * (carriage.motion.velocity + 0.5 * carriage.gained);
  return carriage;
}

// What a sphere pushes along the ground goes on before it, and is not run over. Between surfaces that close
// there is no such way: halfway into both, a body without room is thrown out.
EnergyGuard::Carriage EnergyGuard::best_carriage(const Substep& step, int group) {
  const Carriage own = own_carriage(step, group);
  carry_along(own, group);
  if (!is_entered(group)) return own;
  for (int r = 0; r < world_.rigid.size(); ++r) {
    if (world_.rigid.dynamic(r) || world_.rigid.immobile(r)) continue;
    const Carriage other = carriage_of(r);
    carry_along(other, group);
    if (!is_entered(group)) return other;
  }
  return own;
}

bool EnergyGuard::is_entered(int group) const {
  bool entered = false;
  for_soft(group, [&](const SceneSoftBody& soft) {
    entered |= soft.contacts && deepest_penetration(soft.body, world_.rigid, *soft.contacts) >
                                    promised_depth * soft.body.cell_size;
  });
  return entered;
}

void EnergyGuard::carry_along(const Carriage& carriage, int group) {
  // By name: clang 14 lets no lambda use a structured binding.
  const Pose &from = carriage.from, &to = carriage.to;
  const RigidPart& motion = carriage.motion;
  const Eigen::Quaterniond turn = to.orientation * from.orientation.conjugate();
  RigidPart motion_after = motion;
  motion_after.center = to.to_world(from.to_local(motion.center));
  motion_after.velocity += carriage.gained;
  for_soft(group, [&](SceneSoftBody& soft) {
    SoftBody& body = soft.body;
    for (std::size_t i = 0; i < body.size(); ++i) {
      const Vec3 x = body.start_positions.at(i), inner = body.start_velocities.at(i) - motion.velocity_at(x);
      const Vec3 after = to.to_world(from.to_local(x));
      const bool held = body.inverse_masses[i] == 0.0;
      body.positions.set(i, held ? body.positions.at(i) : after);
      body.velocities.set(
          i, held ? body.velocities.at(i) : Vec3(motion_after.velocity_at(after) + kept * (turn * inner)));
    }
  });
  for_rigid(group, [&](int r) {
    RigidBodyState state = rigid_start_[static_cast<std::size_t>(r)];
    const Vec3 inner = state.velocity - motion.velocity_at(state.pose.position);
    const Vec3 inner_spin = state.angular_velocity() - motion.angular_velocity;
    state.pose.position = to.to_world(from.to_local(state.pose.position));
    state.pose.orientation = turn * state.pose.orientation;
    state.velocity = motion_after.velocity_at(state.pose.position) + kept * (turn * inner);
    state.angular_momentum = world_inertia(state) * (motion.angular_velocity + kept * (turn * inner_spin));
    world_.rigid.set_state(r, state);
  });
}

void EnergyGuard::halt(const Substep& step, int group) {
  ++step.stats.recoveries;
  carry_along(best_carriage(step, group), group);
  for_soft(group, [&](SceneSoftBody& soft) {
    soft.recovered = true;
    ++soft.halts_in_a_row;
    soft.inverted = soft.began_inverted;
    soft.forces_valid = false;
    soft.spring_energy.reset();
    soft.gained = soft.kick_due = 0.0;
    if (soft.contacts) soft.contacts->hold_back(soft.body, 0.0, Vec3::Zero());
  });
}

bool gains_energy(const Substep& step, const SceneSoftBody& soft) {
  if (soft.touched || !soft.pins.empty() || !soft.attachments.empty() ||
      (soft.contacts && soft.contacts->emerging()) || (step.world.grab && step.world.grab->body == soft.id))
    return false;
  const SoftBody& body = soft.body;
  const Vec3& gravity = step.world.scene.gravity;
  const double work = soft.contacts ? std::max(soft.contacts->work(body), 0.0) : 0.0;
  double energy = spring_energy(body.springs, body.material, body.positions) + gravity_energy(body, gravity);
  double inside = spring_energy(body.springs, body.material, body.start_positions) +
                  0.5 * body.total_mass * (step.h * gravity).squaredNorm();
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 moved = body.positions.at(i) - body.start_positions.at(i);
    energy += 0.5 * body.masses[i] * moved.squaredNorm() / (step.h * step.h);
    inside += 0.5 * body.masses[i] * body.start_velocities.at(i).squaredNorm();
  }
  return energy > start_energy(body, gravity) + work + 0.05 * inside;
}

bool keep_ledger(const World& world, SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  const double excess = total_energy(body, world.scene.gravity) - soft.energy_ledger;
  if (!(excess > 0.0)) return true;
  const RigidPart motion = body.has_pins ? RigidPart{} : rigid_part(body, body.positions, body.velocities);
  return damp_about(motion, excess, body) == excess;
}

}  // namespace isochor
