#pragma once
#include <span>
#include <vector>

#include "core/rigid/broad_phase.h"
#include "core/rigid/contact.h"
#include "core/rigid/impacts.h"

namespace isochor {

/// 1/s, of their depth: at that rate bodies placed in each other come out. Put right at once they would part
/// with the speed depth/h.
inline constexpr double emerging_rate = 10.0;

/// The contacts of one step: found at its start, or where bodies meet on the way, and completed by what the
/// predicted poses show. Contacts that last from step to step start from their last impulses.
class StepContacts {
 public:
  void begin(const StepWorld& world, std::span<const BodyPair> jointed);
  /// Adds the points at which the predicted poses overlap although no contact watches them, and renews those
  /// contacts that see them less deep than they are. True when there were any.
  bool complete(const StepWorld& world, std::span<const Pose> predicted);
  /// The contacts at the poses of the step's end: those closer than closed, and those that pressed on the
  /// way.
  void renew(const StepWorld& world, double closed);

  /// Bodies that a step leaves in each other come out as though they had been placed so.
  void leave_within(BodyPair pair);

  std::vector<RigidContact> contacts;

 private:
  void find_touching(const StepWorld& world);
  void let_emerge(const StepWorld& world, RigidContact& contact) const;
  void find_ahead(const StepWorld& world);
  void continue_from_last();
  RigidContact* find_known(const RigidContact& contact, double near);
  bool follow(const StepWorld& world, const RigidContact& contact, std::span<const Pose> poses,
              RigidContact& known) const;

  BroadPhase broad_phase_;
  std::vector<BodyPair> apart_;     ///< pairs that do not touch at the start
  std::vector<BodyPair> emerging_;  ///< pairs placed in each other, until they are out
  bool started_ = false;
  Impacts impacts_;
  Impact impact_;
  std::vector<RigidContact> last_;   ///< of the stage before, sorted by pair
  std::vector<RigidContact> fresh_;  ///< scratch
};

}  // namespace isochor
