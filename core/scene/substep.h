#pragma once
#include "core/scene/world.h"

namespace isochor {

/// Largest cell error where a frame does not end yet: energies differ by less than 1e-3 from those of 1e-6,
/// at half the cost. Ten times as much shows.
constexpr double tolerance_within_frames = 1e-4;

/// What the phases of a substep share.
struct Substep {
  World& world;
  StepStats& stats;
  double h;
  double tolerance;        ///< largest relative volume error of a cell that it may end with
  bool may_halve = false;  ///< a substep that fails is taken again in two halves
  bool may_lift = true;    ///< tets that invert are lifted within it
  bool held = false;       ///< rigid bodies that others press on stay where these have left them

  ComplianceOf compliance_of() const {
    return [this](int source) { return world.rigid.compliance(source); };
  }
};

/// Lists the rigid bodies with a mass, as they are.
void list_massive(World& world);
/// That of the body's integrator.
Phase stepping_phase(const SceneSoftBody& soft);
/// Forces at the present positions, for the kicks before and after a substep; none where springs are stepped
/// implicitly.
void evaluate_forces(World& world, SceneSoftBody& soft);
/// v += seconds·(g + w·f).
void kick(World& world, SceneSoftBody& soft, double seconds);
/// Dragging with the mouse, for one body.
void follow_grab(const Substep& step, SceneSoftBody& soft);
/// Pinned particles go to where they are held at the end of the substep.
void follow_pins(World& world, SceneSoftBody& soft);

/// Contacts with rigid bodies and volume together, the active set of contacts repeated until it stands; then
/// the inequality of inverted tets, alternating with both. Sets soft.inverted.
void constrain(const Substep& step, SceneSoftBody& soft);
/// The same for what has moved the body's contacts since. False when nothing has.
bool constrain_again(const Substep& step, SceneSoftBody& soft);
/// Both for all bodies: those that press on the same rigid ones with a mass take turns.
void constrain_in_turns(const Substep& step);
/// One round of that active set; true when it has changed, and the volume with it.
bool renew_contacts(const Substep& step, SceneSoftBody& soft, int round);
/// Cells have been pulled apart so far that no contact and no lift leads back.
bool has_burst(const ProjectionResult& result);
/// Cells pressed flat answer to volumes by leaps: a particle was found 7 m away after a frame. That is no
/// cure.
bool throws_a_particle(const Substep& step, const SoftBody& body);
/// A start whose cells lack their volumes: the body goes there, out of rigid bodies and right side out,
/// before anything moves. That is no motion: velocities stay as they were given.
void bring_to_volume(const Substep& step, SceneSoftBody& soft);
/// The volume alone, contacts with rigid bodies held.
void project_volume(const Substep& step, SceneSoftBody& soft, double tolerance);
/// Of a body that stands where an earlier substep, of a larger tolerance, has left it. Velocities stay.
void refine_volume(const Substep& step, SceneSoftBody& soft);
/// The inequality of inverted tets, alternating with the volume; true when there were any.
bool lift_inverted(const Substep& step, SceneSoftBody& soft);
/// What the last projection of the substep has reached goes into the frame's figures.
void record_projection(const Substep& step, const SceneSoftBody& soft);

/// Contacts between deformable bodies, from before their volumes are projected.
void begin_collision(const Substep& step);
/// These contacts, those with rigid bodies and the volumes of all bodies that touch, together. False when
/// gaps are left that frames promise to close.
bool collide(const Substep& step);

/// Particles attached to rigid bodies with a mass go where these are going. True when that is news.
bool follow_attachments(const World& world, SceneSoftBody& soft);

/// Contacts of a body whose springs are stepped implicitly: balanced within the implicit solve, so that all
/// of the body gives way and not the particles at its surface alone. What the projection still moves after it
/// is of the second order. False when forces would not balance.
bool press_implicitly(const Substep& step, SceneSoftBody& soft);

/// Rigid bodies with a mass answer to what presses on them: by their own motion, and by what they touch and
/// are jointed to.
void answer(const Substep& step, SceneSoftBody& soft);
/// Gives rigid bodies with a mass what the contacts of a soft one still owe them.
void hand_out(const Substep& step, SceneSoftBody& soft);

/// For a start that is inverted already: up to 30 rounds of inequality and projection that leave the
/// velocities alone.
void recover_inverted(const Substep& step, SceneSoftBody& soft);

/// The body, at the end of the substep but with its velocities still to be taken from its positions, has more
/// energy than at its start and by the work of what presses on it, by over a twentieth of what it had inside.
/// Never so where pins, attachments, the mouse or other deformable bodies move it.
bool gains_energy(const Substep& step, const SceneSoftBody& soft);
/// A body that swings freely has no more energy than its ledger: what the solve has left over is taken from
/// its deformation. False when that has not enough.
bool keep_ledger(const World& world, SceneSoftBody& soft);

}  // namespace isochor
