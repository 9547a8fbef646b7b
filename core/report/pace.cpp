#include "core/report/pace.h"

#include <algorithm>
#include <cmath>

namespace isochor {

double Pace::fraction(const SceneSettings& settings, double share, double seconds) {
  constexpr double telling = 0.05;
  if (share > telling) rate(settings) = seconds / (share * work(settings));
  left(settings) -= share * work(settings);
  const double done = spent_ + seconds, to_come = seconds_left();
  left(settings) += share * work(settings);
  return done > 0.0 ? done / (done + to_come) : 0.0;
}

void Pace::end_run(const SceneSettings& settings, double seconds) {
  rate(settings) = seconds / work(settings);
  left(settings) -= work(settings);
  spent_ += seconds;
}

/// Relative: substeps times cells. An implicit step counts as ten; iterations of the solvers that go cell by
/// cell are as many for each decade of the tolerance.
double Pace::work(const SceneSettings& settings) const {
  constexpr int cheap_substeps = 15;
  const bool implicit = settings.springs == SpringIntegrator::automatic
                            ? needed_substeps_ > std::max(cheap_substeps, settings.substeps)
                            : settings.springs != SpringIntegrator::symplectic;
  const double decades = settings.solver == VolumeSolver::newton ? 1.0 : -std::log10(settings.tolerance);
  return (implicit ? 10.0 : 1.0) * std::max(1, settings.substeps) * std::pow(settings.resolution, 3) *
         decades;
}

// Of a solver that has not run yet, what is usual beside those that have.
double Pace::seconds_left() const {
  constexpr std::array<double, 3> usual{1.0, 5.0, 2.0};  // newton, scaling, gradient
  double scale = 0.0, seconds = 0.0;
  for (std::size_t s = 0; s < usual.size(); ++s)
    if (rates_[s]) scale = std::max(scale, *rates_[s] / usual[s]);
  for (std::size_t s = 0; s < usual.size(); ++s)
    seconds += std::max(0.0, left_[s]) * rates_[s].value_or(usual[s] * scale);
  return seconds;
}

}  // namespace isochor
