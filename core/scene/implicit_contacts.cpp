#include <utility>

#include "core/scene/detect_contacts.h"
#include "core/scene/substep.h"

namespace isochor {

// The active set is that of project_with_contacts, but a round solves springs, volume, contacts and how rigid
// bodies give way together.
bool press_implicitly(const Substep& step, SceneSoftBody& soft) {
  constexpr int judging_rounds = 8, most_rounds = 12;  // later ones only add to the set, so that it ends
  SoftBody& body = soft.body;
  ParticleContacts& contacts = *soft.contacts;
  PhaseList& phases = step.world.phases;
  const ComplianceOf compliance_of = step.compliance_of();
  using enum ImplicitStep::Balance;
  // Bodies with a mass answer to every round, and keep what a rough one was off by.
  ImplicitStep::Balance while_judging = step.world.massive.empty() ? rough : full, balance = full;
  std::size_t blocked_last = 0, blocked_before = 0;
  for (int round = 0; round < most_rounds; ++round) {
    bool changed = false;
    phases.run(Phase::contacts, [&] {
      if (round > 0 && round <= judging_rounds) changed = contacts.update(body, true);
      changed |= follow_attachments(step.world, soft);
      changed |= detect_contacts(body, step.world.rigid, step.h, *soft.candidates, contacts);
      if (changed) contacts.place(body);
    });
    if (!changed && balance == full) return true;
    const std::size_t blocked = contacts.blocked().size();
    // What comes and goes presses by less than a rough solve is off.
    if (round > 1 && blocked == blocked_before && blocked != blocked_last) while_judging = full;
    blocked_before = std::exchange(blocked_last, blocked);
    balance = changed && round + 1 < most_rounds ? while_judging : full;
    bool balanced = false;
    phases.run(stepping_phase(soft), [&] {
      const CarrierSpace& carriers = contacts.yielding(body, compliance_of);
      balanced = soft.implicit->solve(body, contacts.blocked(), contacts.frictions(), carriers, balance);
      contacts.set_reactions(body, soft.implicit->reactions(contacts.blocked()));
    });
    if (!balanced) return false;
    answer(step, soft);
  }
  return step.world.massive.empty();
}

}  // namespace isochor
