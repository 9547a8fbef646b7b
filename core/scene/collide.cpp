#include <algorithm>

#include "core/scene/substep.h"
#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

/// Rounds of finding contacts, friction and rigid contacts around the pressures; all but a few settle after
/// two. What is left then, the next substep starts from.
constexpr int max_rounds = 8;
constexpr int friction_rounds = 5;
/// Later, contacts keep their triangles, or a vertex near an edge would go back and forth.
constexpr int moving_rounds = 3;
/// So many rounds in a row whose pressures end nowhere are the last of a substep that can be halved.
constexpr int rounds_in_vain = 3;
/// Gap that a substep leaves alone, in cells; frames promise a tenth of a percent.
constexpr double gap_tolerance = 2e-5;
constexpr double gap_promised = 1e-3;

class SceneProjector final : public BodyProjector {
 public:
  explicit SceneProjector(const Substep& step) : step_(step) {}
  void project(int body, double tolerance) override {
    project_volume(step_, step_.world.soft[body], tolerance);
  }

 private:
  const Substep& step_;
};

}  // namespace

void begin_collision(const Substep& step) {
  World& world = step.world;
  world.phases.run(Phase::surface_contacts, [&] { world.surfaces->begin(world, step.h); });
}

bool collide(const Substep& step) {
  World& world = step.world;
  SurfaceCollision& surfaces = *world.surfaces;
  SurfaceContacts& contacts = surfaces.contacts();
  SceneProjector projector(step);
  const double tolerance = step.tolerance;
  const auto for_touched = [&](const auto& visit) {
    for (std::size_t b = 0; b < world.soft.size(); ++b)
      if (surfaces.touches(b)) visit(world.soft[b]);
  };
  const auto hopeless = [&](int in_vain) {
    return step.may_halve && (in_vain == rounds_in_vain ||
                              std::ranges::any_of(world.soft, has_burst, &SceneSoftBody::projection));
  };
  if (hopeless(0)) return false;
  contacts.recall();
  for (int round = 0, in_vain = 0; round < max_rounds; ++round) {
    bool changed = false;
    world.phases.run(Phase::surface_contacts, [&] {
      changed = surfaces.update(round < moving_rounds);
      if (round <= friction_rounds) changed |= contacts.rub();
    });
    if (contacts.empty()) break;
    for_touched([&](SceneSoftBody& soft) {
      if (soft.contacts) changed |= renew_contacts(step, soft, round + 1);
      project_volume(step, soft, tolerance);
    });
    contacts.take_forces();
    if (!changed && contacts.holds(gap_tolerance)) break;
    in_vain = contacts.solve(projector, tolerance, gap_tolerance) ? 0 : in_vain + 1;
    if (hopeless(in_vain)) return false;
  }
  bool lifted = false;
  for_touched([&](SceneSoftBody& soft) { lifted |= lift_inverted(step, soft); });
  if (lifted) {
    contacts.solve(projector, tolerance, gap_tolerance);
    for_touched([&](SceneSoftBody& soft) { lift_inverted(step, soft); });
  }
  bool apart = false;
  world.phases.run(Phase::surface_contacts, [&] { apart = surfaces.keeps_apart(gap_promised); });
  for (std::size_t b = 0; b < world.soft.size(); ++b) {
    world.soft[b].touched = surfaces.touches(b);
    world.soft[b].entered = surfaces.is_entered(b);
  }
  return apart;
}

}  // namespace isochor
