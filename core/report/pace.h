#pragma once
#include <array>
#include <optional>

#include "core/report/scene_settings.h"

namespace isochor {

/// How far a report is, from what its runs took so far: the solvers differ by a factor of a hundred, in
/// another order on each scene.
class Pace {
 public:
  /// Substeps that symplectic Euler needs, at the finest resolution.
  explicit Pace(int needed_substeps) : needed_substeps_(needed_substeps) {}

  void expect(const SceneSettings& settings, int runs) { left(settings) += runs * work(settings); }
  void leave_out(const SceneSettings& settings, int runs) { left(settings) -= runs * work(settings); }
  /// Share of the whole that is done, when a run has done this share of its frames in these seconds.
  double fraction(const SceneSettings& settings, double share, double seconds);
  void end_run(const SceneSettings& settings, double seconds);

 private:
  double work(const SceneSettings& settings) const;
  double& left(const SceneSettings& settings) { return left_[static_cast<std::size_t>(settings.solver)]; }
  std::optional<double>& rate(const SceneSettings& settings) {
    return rates_[static_cast<std::size_t>(settings.solver)];
  }
  double seconds_left() const;

  int needed_substeps_;
  double spent_ = 0.0;                               ///< seconds
  std::array<double, 3> left_{};                     ///< work to come, by solver
  std::array<std::optional<double>, 3> rates_ = {};  ///< seconds a unit of work, by solver, as last seen
};

}  // namespace isochor
