#include "core/scene/phases.h"

namespace isochor {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(Phase::count)> phase_names{"gravity",
                                                                                      "edge_springs",
                                                                                      "diagonal_springs",
                                                                                      "spring_damping",
                                                                                      "symplectic_euler",
                                                                                      "implicit_euler",
                                                                                      "energy_momentum",
                                                                                      "pins",
                                                                                      "grab",
                                                                                      "attachments",
                                                                                      "rigid_bodies",
                                                                                      "joints",
                                                                                      "contacts",
                                                                                      "surface_contacts",
                                                                                      "friction",
                                                                                      "restitution",
                                                                                      "volume",
                                                                                      "inversion"};

}  // namespace

void PhaseList::set(Phase phase, bool included, std::string reason) {
  PlannedPhase& entry = at(phase);
  entry.name = phase_names[static_cast<std::size_t>(phase)];
  entry.included = included;
  entry.reason = std::move(reason);
  if (!included) entry.bytes = 0, entry.ms = 0.0;
}

}  // namespace isochor
