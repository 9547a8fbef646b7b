#pragma once
#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "core/parallel/cancel_scope.h"
#include "core/scene/simulation.h"

namespace isochor {

/// The phases of a step in the order of the plan; core/scene/README.md says what each does.
enum class Phase {
  gravity,
  edge_springs,
  diagonal_springs,
  spring_damping,
  symplectic_euler,
  implicit_euler,
  energy_momentum,
  pins,
  grab,
  attachments,
  rigid_bodies,
  joints,
  contacts,
  surface_contacts,
  friction,
  restitution,
  volume,
  inversion,
  count
};

/// Which phases a scene was compiled to, and what they have cost.
class PhaseList {
 public:
  bool has(Phase phase) const { return at(phase).included; }
  void include(Phase phase, std::string reason) { set(phase, true, std::move(reason)); }
  void leave_out(Phase phase, std::string reason) { set(phase, false, std::move(reason)); }
  void set_bytes(Phase phase, std::int64_t bytes) { at(phase).bytes = has(phase) ? bytes : 0; }

  /// Runs the work of a phase when it is in the list, and counts its time.
  template <class Work>
  void run(Phase phase, Work&& work) {
    if (!has(phase)) return;
    throw_if_scope_cancelled();
    const auto begin = std::chrono::steady_clock::now();
    work();
    at(phase).ms +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  }

  std::vector<PlannedPhase> plan() const { return {phases_.begin(), phases_.end()}; }

 private:
  void set(Phase phase, bool included, std::string reason);
  PlannedPhase& at(Phase phase) { return phases_[static_cast<std::size_t>(phase)]; }
  const PlannedPhase& at(Phase phase) const { return phases_[static_cast<std::size_t>(phase)]; }

  std::array<PlannedPhase, static_cast<std::size_t>(Phase::count)> phases_;
};

}  // namespace isochor
