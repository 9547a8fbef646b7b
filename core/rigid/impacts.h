#pragma once
#include <span>
#include <vector>

#include "core/rigid/broad_phase.h"
#include "core/rigid/contact.h"
#include "core/rigid/impulse_solver.h"
#include "core/rigid/joint.h"
#include "core/rigid/time_of_impact.h"

namespace isochor {

/// What the search for contacts works on in one step.
struct StepWorld {
  std::span<BodyRecord> bodies;
  std::span<const RigidJoint> joints;
  Vec3 gravity;
  double h = 0.0;
  double slop = 0.0;  ///< metres: bodies that near touch
};

/// Bodies that meet within the step: each impact is resolved at its time and place, in order of time,
/// together with all that the two bodies touch or are jointed to. Then every body is put where, with its new
/// velocity, it would have started from. So the rest of the step need not know, and energy, momentum and the
/// angle of a billiard shot come out exactly.
class Impacts {
 public:
  /// contacts: in, the points that touch at the start; out, those at which bodies met are added. Looks at the
  /// given pairs, none of which touches at the start.
  void resolve(const StepWorld& world, std::span<const BodyPair> apart, std::vector<RigidContact>& contacts);

 private:
  struct Meeting {
    BodyPair pair;
    double time = 0.0;  ///< beyond h: they do not meet
    int met = 0;        ///< times within this step
  };
  void look(const StepWorld& world, Meeting& meeting, double from);
  void resolve_one(const StepWorld& world, const Meeting& meeting, std::vector<RigidContact>& contacts);
  void gather(const StepWorld& world, BodyPair pair, std::span<const RigidContact> contacts);
  bool join(const StepWorld& world, int a, int b);
  void push_apart(const StepWorld& world, BodyPair pair, std::span<const RigidContact> contacts);
  void add_meeting_rows(const StepWorld& world, BodyPair pair);
  void add_lasting_rows(const StepWorld& world, std::span<const RigidContact> contacts);
  void add_rates(const StepWorld& world, std::size_t first_row);

  std::vector<Meeting> meetings_;
  Impact impact_;
  std::vector<int> members_;        ///< bodies that feel the impact
  std::vector<int> member_of_;      ///< a body: its place among them, or −1
  std::vector<Pose> member_poses_;  ///< before the impact
  ImpulseSolver solver_;
  ConstraintSet set_;
  std::vector<SolverBody> solver_bodies_;
};

/// Points of a manifold as contacts of the bodies at the poses.
void append_contacts(BodyPair pair, std::span<const BodyRecord> bodies, const Manifold& manifold,
                     const Pose& pose_a, const Pose& pose_b, std::vector<RigidContact>& contacts);

}  // namespace isochor
