#include "core/scene/metrics.h"

#include <cmath>

#include "core/dynamics/inversion.h"
#include "core/scene/detect_contacts.h"
#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

/// In which the volumes here and in the solvers may differ, relative.
constexpr double round_off = 1e-13;

void add_volumes(const World& world, Metrics& metrics) {
  double volume = 0.0, rest = 0.0;
  for (const SceneSoftBody& soft : world.soft) {
    const CellVolumeErrors errors = volume_errors(soft.body);
    volume += errors.volume;
    rest += soft.body.rest_volume;
    if (errors.max_cell_error <= metrics.max_cell_volume_error) continue;
    metrics.max_cell_volume_error = errors.max_cell_error;
    metrics.worst_cell = errors.worst_cell;
    metrics.worst_body = soft.id;
  }
  if (rest > 0.0) metrics.total_volume_error = std::abs(volume - rest) / rest;
}

void add_motion(const World& world, Metrics& metrics) {
  const Vec3& gravity = world.scene.gravity;
  metrics.kinetic_energy = world.rigid.kinetic_energy();
  metrics.potential_energy = world.rigid.gravity_energy();
  metrics.linear_momentum = world.rigid.linear_momentum();
  metrics.angular_momentum = world.rigid.angular_momentum();
  for (const SceneSoftBody& soft : world.soft) {
    metrics.kinetic_energy += kinetic_energy(soft.body);
    metrics.potential_energy += gravity_energy(soft.body, gravity) +
                                spring_energy(soft.body.springs, soft.body.material, soft.body.positions);
    const Momentum sum = momentum(soft.body);
    metrics.linear_momentum += sum.linear;
    metrics.angular_momentum += sum.angular;
  }
}

}  // namespace

Metrics measure(const World& world, const StepStats& stats) {
  Metrics metrics;
  metrics.iterations = stats.iterations;
  metrics.substeps = stats.substeps;
  metrics.h = stats.smallest_h;
  metrics.recoveries = stats.recoveries;
  metrics.fallbacks = stats.fallbacks;
  metrics.feasible = stats.feasible;
  metrics.contacts = stats.contacts;
  metrics.contacts += world.rigid.metrics().contacts;
  metrics.max_penetration = world.rigid.metrics().max_penetration;
  add_volumes(world, metrics);
  add_motion(world, metrics);
  // A body that was left as it stood may have started so.
  metrics.feasible &= stats.substeps == 0 || metrics.max_cell_volume_error <=
                                                 world.scene.solver.tolerance * (1.0 + 1e-6) + round_off;
  for (const SceneSoftBody& soft : world.soft) {
    metrics.inverted += count_inverted(*soft.body.mesh, soft.body.positions);
    if (!soft.contacts) continue;
    const double depth = deepest_penetration(soft.body, world.rigid, *soft.contacts);
    metrics.max_penetration = std::max(metrics.max_penetration, depth);
    metrics.feasible &= stats.substeps == 0 || depth <= promised_depth * soft.body.cell_size;
  }
  if (world.surfaces) {
    const auto deepest = world.surfaces->deepest_penetration(world);
    metrics.max_penetration = std::max(metrics.max_penetration, deepest.depth);
    metrics.feasible &= stats.substeps == 0 || deepest.cells <= promised_depth;
  }
  return metrics;
}

}  // namespace isochor
