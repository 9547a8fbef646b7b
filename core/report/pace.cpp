#include "core/report/pace.h"

#include <algorithm>
#include <cmath>

namespace isochor {

double Pace::fraction(const SceneSettings& settings, double share, double seconds) const {
  const Solvers now = after(settings, share, seconds);
  double spent = 0.0;
  for (const OfSolver& solver : now) spent += solver.seconds;
  return spent > 0.0 ? spent / (spent + seconds_left(now)) : 0.0;
}

void Pace::end_run(const SceneSettings& settings, double seconds) {
  solvers_ = after(settings, 1.0, seconds);
}

Pace::Solvers Pace::after(const SceneSettings& settings, double share, double seconds) const {
  Solvers solvers = solvers_;
  OfSolver& solver = solvers[static_cast<std::size_t>(settings.solver)];
  solver.left -= share * work(settings);
  solver.done += share * work(settings);
  solver.seconds += seconds;
  return solvers;
}

/// Relative: substeps times cells. An implicit step counts as ten; iterations of the solvers that go cell by
/// cell are as many for each decade of the tolerance, and grow with the cells.
double Pace::work(const SceneSettings& settings) const {
  constexpr int cheap_substeps = 15;
  const bool implicit = settings.springs == SpringIntegrator::automatic
                            ? needed_substeps_ > std::max(cheap_substeps, settings.substeps)
                            : settings.springs != SpringIntegrator::symplectic;
  const bool by_cell = settings.solver != VolumeSolver::newton;
  const double iterations =
      by_cell ? -std::log10(settings.tolerance) * std::pow(settings.resolution, 3) : 1.0;
  return (implicit ? 10.0 : 1.0) * std::max(1, settings.substeps) * std::pow(settings.resolution, 3) *
         iterations;
}

// Of a solver that has not run yet, what is usual beside those that have.
double Pace::seconds_left(const Solvers& solvers) {
  constexpr std::array<double, 3> usual{1.0, 5.0, 2.0};  // newton, scaling, gradient
  double scale = 0.0, seconds = 0.0;
  for (std::size_t s = 0; s < usual.size(); ++s)
    if (solvers[s].done > 0.0) scale = std::max(scale, solvers[s].seconds / solvers[s].done / usual[s]);
  for (std::size_t s = 0; s < usual.size(); ++s) {
    const double rate = solvers[s].done > 0.0 ? solvers[s].seconds / solvers[s].done : usual[s] * scale;
    seconds += std::max(0.0, solvers[s].left) * rate;
  }
  return seconds;
}

}  // namespace isochor
