#include "core/scene/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/dynamics/lattice_box.h"
#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

/// Substeps up to which symplectic Euler is both the cheapest and by far the most accurate choice.
constexpr int cheap_substeps = 15;
/// Where deformable bodies meet: those stepped implicitly are pushed apart against their springs, which then
/// hold more energy than the impact had. Stacks of them are halted, or gain energy and go into each other.
constexpr int meeting_substeps = 400;
/// Where a body that is no box may touch rigid ones: the implicit solve's preconditioner is a box, and
/// contacts take a hundred solves of hundreds of iterations.
constexpr int awkward_substeps = 100;
/// Beyond this a frame of symplectic steps is refused even when asked for.
constexpr int most_substeps = 20000;

std::int64_t bytes_of(const Coordinates& c) {
  return static_cast<std::int64_t>(3 * c.size() * sizeof(double));
}

/// Without edges a stretch at constant volume holds next to no energy, and its swing by (hω)²/4 shows:
/// to 1.09 of what it was at the edge of stability, to 1.06 at half of (hω)², to 1.03 at a fifth.
constexpr double diagonals_alone = 5.0;

/// Substeps a frame that symplectic Euler needs for this body.
double needed_substeps(const SceneSoftBody& soft, double frame) {
  const SoftBody& body = soft.body;
  const double bound = gershgorin_bound(body.springs, body.material, body.inverse_masses);
  const double lambda = body.springs.edges.empty() ? diagonals_alone * bound : bound;
  return std::ceil(frame / stable_substep(lambda, body.material.damping));
}

class Planner {
 public:
  explicit Planner(World& world) : world_(world), phases_(world.phases) {}

  void run() {
    integrators();
    forces();
    constraints();
    contacts();
  }

 private:
  const std::string& name(const SceneSoftBody& soft) const { return world_.scene.bodies[soft.id].name; }

  void decide(Phase phase, bool included, std::string why, std::string why_not) {
    if (included)
      phases_.include(phase, std::move(why));
    else
      phases_.leave_out(phase, std::move(why_not));
  }

  void integrators() {
    const SolverOptions& solver = world_.scene.solver;
    const double frame = 1.0 / world_.scene.frame_rate;
    std::string symplectic, implicit, filtered;
    double substeps = std::max(1, solver.substeps);
    for (SceneSoftBody& soft : world_.soft) {
      const double needed = needed_substeps(soft, frame);
      const SpringIntegrator chosen = choose(soft, needed);
      set_integrator(soft, chosen);
      std::string& reasons = chosen == SpringIntegrator::symplectic ? symplectic
                             : chosen == SpringIntegrator::implicit ? implicit
                                                                    : filtered;
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : "; ", name(soft), why(soft, needed, chosen));
      if (chosen == SpringIntegrator::symplectic) substeps = std::max(substeps, needed);
    }
    world_.substeps = static_cast<int>(std::min<double>(substeps, most_substeps));
    const auto decide_step = [&](Phase phase, const std::string& reasons, const char* others) {
      decide(phase, !reasons.empty(), reasons, world_.soft.empty() ? "no deformable body" : others);
    };
    decide_step(Phase::symplectic_euler, symplectic, "the springs of every body are stepped implicitly");
    decide_step(Phase::implicit_euler, implicit, "no body's springs are stepped by implicit Euler");
    decide_step(Phase::energy_momentum, filtered, "no body is asked to be stiff and lively");
  }

  SpringIntegrator choose(const SceneSoftBody& soft, double needed) const {
    const SpringStencil& springs = soft.body.springs;
    const SolverOptions& solver = world_.scene.solver;
    if (springs.edges.empty() && springs.diagonals.empty()) return SpringIntegrator::symplectic;
    if (is_refused(needed)) return SpringIntegrator::implicit;
    if (solver.springs != SpringIntegrator::automatic) return solver.springs;
    return needed > std::max(affordable_substeps(soft), solver.substeps) ? SpringIntegrator::implicit
                                                                         : SpringIntegrator::symplectic;
  }

  /// In fewer substeps than it needs it would blow up.
  bool is_refused(double needed) const {
    return world_.scene.solver.springs == SpringIntegrator::symplectic && !(needed <= most_substeps);
  }

  int affordable_substeps(const SceneSoftBody& soft) const {
    if (world_.surfaces) return meeting_substeps;
    return world_.rigid.size() > 0 && !fills_its_box(*soft.body.mesh) ? awkward_substeps : cheap_substeps;
  }

  std::string why(const SceneSoftBody& soft, double needed, SpringIntegrator chosen) const {
    if (chosen == SpringIntegrator::symplectic)
      return fmt::format("needs {} substep{} a frame by the Gershgorin bound", needed,
                         needed == 1.0 ? "" : "s");
    const std::string bound =
        fmt::format("would need {} symplectic substeps a frame by the Gershgorin bound", needed);
    if (world_.scene.solver.springs == SpringIntegrator::automatic)
      return fmt::format("{}, more than {}", bound, affordable_substeps(soft));
    if (is_refused(needed))
      return fmt::format("is asked not to be, but {}, more than {}", bound, most_substeps);
    return fmt::format("is asked to be; it {}", bound);
  }

  void set_integrator(SceneSoftBody& soft, SpringIntegrator chosen) {
    if (chosen != soft.integrator) soft.forces_valid = false;
    soft.integrator = soft.stepping = chosen;
    soft.energy_ledger = total_energy(soft.body, world_.scene.gravity);
    if (chosen == SpringIntegrator::symplectic)
      soft.implicit.reset();
    else if (!soft.implicit)
      soft.implicit = std::make_unique<ImplicitStep>(soft.body);
  }

  int massive_bodies() const {
    int massive = 0;
    for (int r = 0; r < world_.rigid.size(); ++r) massive += world_.rigid.dynamic(r);
    return massive;
  }

  void forces() {
    const auto any = [&](auto has) { return std::ranges::any_of(world_.soft, has); };
    const bool pulls = !world_.scene.gravity.isZero(0.0);
    const bool falls = !world_.soft.empty() || massive_bodies() > 0;
    decide(Phase::gravity, pulls && falls, "the scene has gravity",
           pulls ? "no body has a mass" : "gravity is zero");
    decide(Phase::edge_springs, any([](const SceneSoftBody& s) { return !s.body.springs.edges.empty(); }),
           "12 edges a cell, shared ones merged", "no body has an edge stiffness");
    decide(Phase::diagonal_springs,
           any([](const SceneSoftBody& s) { return !s.body.springs.diagonals.empty(); }),
           "4 space diagonals a cell", "no body has a diagonal stiffness");
    decide(Phase::spring_damping, any([](const SceneSoftBody& s) { return s.body.material.damping > 0.0; }),
           "a body has damping: the spring kernels take velocities",
           "damping is zero: the spring kernels take positions only");
    decide(Phase::pins, any([](const SceneSoftBody& s) { return !s.pins.empty(); }), "particles are pinned",
           "the scene pins nothing");
    decide(Phase::attachments, any([](const SceneSoftBody& s) { return !s.attachments.empty(); }),
           "particles are attached to rigid bodies with a mass: held as contacts that never let go",
           "nothing is attached to a rigid body with a mass");
    decide(Phase::grab, world_.grab.has_value(), "a particle is being dragged", "nothing is being dragged");
  }

  void constraints() {
    const SolverOptions& solver = world_.scene.solver;
    const char* names[] = {"inexact Newton on the whole body", "each cell scaled in turn",
                           "each cell along its gradient in turn"};
    const char* scope =
        solver.constraint == ConstraintScope::per_tet ? "one constraint a tet" : "one constraint a cell";
    decide(Phase::volume, !world_.soft.empty(),
           fmt::format("{}, {}", names[static_cast<int>(solver.volume)], scope), "no deformable body");
    decide(Phase::inversion, !world_.soft.empty(), "every substep checks its tets", "no deformable body");
  }

  void contacts() {
    const bool rigid = world_.rigid.size() > 0, soft = !world_.soft.empty();
    const int massive = massive_bodies();
    decide(Phase::rigid_bodies, rigid,
           fmt::format("{} rigid, {} of them with a mass", world_.rigid.size(), massive), "no rigid body");
    decide(Phase::joints, !world_.scene.joints.empty(),
           fmt::format("{} between rigid bodies, timed with them", world_.scene.joints.size()),
           "the scene has no joint");
    const char* nobody = rigid ? "no deformable body" : "no rigid body to touch";
    decide(Phase::contacts, rigid && soft,
           massive > 0 ? "surface particles against rigid bodies, which give way inside the volume projection"
                       : "surface particles against rigid bodies, inside the volume projection",
           nobody);
    const std::int64_t folding = std::ranges::count_if(world_.soft, [&](const SceneSoftBody& s) {
      return std::get<DeformableBody>(world_.scene.bodies[s.id].kind).self_contact;
    });
    decide(Phase::surface_contacts, world_.surfaces != nullptr,
           fmt::format(
               "{} deformable, {} with contact with itself: surface vertices against triangles, found by a "
               "spatial hash, solved together with the volumes",
               world_.soft.size(), folding),
           soft ? "one deformable body, without contact with itself: no hash" : "no deformable body");
    bool rubs = false, bounces = false;
    for (const SceneBody& body : world_.scene.bodies) {
      rubs |= body.friction > 0.0;
      bounces |= body.restitution > 0.0;
    }
    const bool touches = (rigid && soft) || world_.surfaces;
    const char* alone = rigid ? "no deformable body; that of rigid ones is timed with them" : nobody;
    decide(Phase::friction, touches && rubs, "Coulomb's cone, in the contacts' active set",
           rubs ? alone : "friction is zero");
    decide(Phase::restitution, touches && bounces, "a body bounces", bounces ? alone : "restitution is zero");
  }

  World& world_;
  PhaseList& phases_;
};

}  // namespace

void plan_phases(World& world) {
  Planner(world).run();
}

void measure_phases(const World& world, PhaseList& phases) {
  std::int64_t edges = 0, diagonals = 0, contacts = 0, volume = 0, inversion = 0, pins = 0, attachments = 0,
               symplectic = 0, implicit = 0, lively = 0;
  for (const SceneSoftBody& soft : world.soft) {
    const SoftBody& body = soft.body;
    edges += body.springs.edges.bytes();
    diagonals += body.springs.diagonals.bytes();
    volume += body.projector->bytes();
    attachments += static_cast<std::int64_t>(soft.attachments.capacity() * sizeof(PinnedParticle));
    pins += static_cast<std::int64_t>(soft.pins.capacity() * sizeof(PinnedParticle));
    if (soft.tets) inversion += soft.tets->bytes();
    if (soft.contacts) contacts += soft.contacts->bytes() + soft.candidates->bytes();
    std::int64_t& integrator = soft.integrator == SpringIntegrator::symplectic ? symplectic
                               : soft.integrator == SpringIntegrator::implicit ? implicit
                                                                               : lively;
    if (soft.implicit) integrator += soft.implicit->bytes();
    integrator += bytes_of(body.positions) + bytes_of(body.velocities) + bytes_of(body.start_positions) +
                  bytes_of(body.start_velocities) + bytes_of(body.forces);
  }
  phases.set_bytes(Phase::rigid_bodies, world.rigid.bytes());
  phases.set_bytes(Phase::edge_springs, edges);
  phases.set_bytes(Phase::diagonal_springs, diagonals);
  phases.set_bytes(Phase::volume, volume);
  phases.set_bytes(Phase::pins, pins);
  phases.set_bytes(Phase::attachments, attachments);
  phases.set_bytes(Phase::contacts, contacts);
  phases.set_bytes(Phase::inversion, inversion);
  phases.set_bytes(Phase::symplectic_euler, symplectic);
  if (world.surfaces) phases.set_bytes(Phase::surface_contacts, world.surfaces->bytes());
  phases.set_bytes(Phase::implicit_euler, implicit);
  phases.set_bytes(Phase::energy_momentum, lively);
}

}  // namespace isochor
