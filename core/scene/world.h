#pragma once
#include "core/dynamics/implicit_step.h"
#include "core/dynamics/inversion.h"
#include "core/dynamics/particle_contacts.h"
#include "core/rigid/rigid_world.h"
#include "core/scene/detect_contacts.h"
#include "core/scene/phases.h"
#include "core/scene/scene.h"

namespace isochor {

/// A particle held in place, or by a rigid body.
struct PinnedParticle {
  std::int32_t particle = 0;
  int rigid = -1;              ///< in the RigidWorld; −1 holds it in place
  Vec3 anchor = Vec3::Zero();  ///< in the rigid body's frame, or in the world's
};

/// A deformable body of the scene with what the scene attaches to it.
struct SceneSoftBody {
  int id = 0;  ///< index in Scene::bodies
  SoftBody body;
  std::shared_ptr<const Model> model;             ///< when made from a mesh
  std::vector<PinnedParticle> pins;               ///< in place, or to a rigid body that nothing moves
  std::vector<PinnedParticle> attachments;        ///< to rigid bodies with a mass, which feel them
  std::unique_ptr<ParticleContacts> contacts;     ///< absent when the scene has nothing to touch
  std::unique_ptr<ContactCandidates> candidates;  ///< with them
  std::unique_ptr<TetInequality> tets;
  SpringIntegrator integrator = SpringIntegrator::symplectic;  ///< of its springs, never automatic
  std::unique_ptr<ImplicitStep> implicit;                      ///< unless the integrator is symplectic
  SpringIntegrator stepping = SpringIntegrator::symplectic;    ///< that of this substep
  double energy_ledger = 0.0;  ///< J; what a stiff and lively body may have, see Stepper::settle
  /// W, of what moves and presses on it, in the last substep without recovery.
  double contact_power = 0.0;
  double gained = 0.0;                  ///< J, in the contact that it is in: the swing of symplectic steps
  std::optional<double> spring_energy;  ///< J, as the substep begins, where it is known
  int halts_in_a_row = 0;               ///< substeps that the guard of energy has taken back
  double kick_due = 0.0;                ///< s of gravity that the last substep has left to this one
  bool started = false;                 ///< brought to its volumes, if its start lacked them
  bool finished = false;                ///< with this substep already
  bool forces_valid = false;            ///< body.forces are those of the present positions
  bool pressed_implicitly = false;      ///< its contacts were balanced within the implicit solve
  bool unbalanced = false;              ///< that solve failed
  bool recovered = false;               ///< moved by the inequality of its tets in this substep
  bool inverted = false;                ///< some tet was, at the end of the last substep
  ProjectionResult projection;          ///< the last of this substep
  bool began_inverted = false;          ///< some tet was, as the substep began
  bool touched = false;                 ///< by a deformable body in this substep, or by itself
  bool entered = false;                 ///< the substep leaves them in each other
};

class SurfaceCollision;

/// A compiled scene: what steps.
struct World {
  World();
  World(World&&) noexcept;
  ~World();

  Scene scene;
  PhaseList phases;
  std::vector<SceneSoftBody> soft;
  RigidWorld rigid;
  std::vector<int> rigid_ids;                  ///< index in Scene::bodies of each body of the RigidWorld
  std::vector<Vec3> rigid_centers;             ///< of mass, in the frames of the scene's bodies
  std::vector<MassiveBody> massive;            ///< those of them with a mass, as the substep began
  std::unique_ptr<SurfaceCollision> surfaces;  ///< absent when no deformable body can meet one
  std::optional<Grab> grab;
  int substeps = 1;  ///< a frame
};

/// What a frame's substeps did.
struct StepStats {
  int iterations = 0, substeps = 0, recoveries = 0, fallbacks = 0;
  double smallest_h = 0.0;
  std::int64_t contacts = 0;  ///< in the last substep
  bool feasible = true;
  double worst_error = 0.0;
  int worst_body = -1;
  std::int64_t worst_cell = -1;
};

}  // namespace isochor
