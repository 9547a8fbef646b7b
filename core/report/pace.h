#pragma once
#include <array>

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
  double fraction(const SceneSettings& settings, double share, double seconds) const;
  void end_run(const SceneSettings& settings, double seconds);

 private:
  double work(const SceneSettings& settings) const;
  double& left(const SceneSettings& settings) {
    return solvers_[static_cast<std::size_t>(settings.solver)].left;
  }

  struct OfSolver {
    double left = 0.0, done = 0.0;  ///< work
    double seconds = 0.0;           ///< that the work done took
  };
  using Solvers = std::array<OfSolver, 3>;
  static double seconds_left(const Solvers& solvers);
  /// After a share of a run that takes these seconds.
  Solvers after(const SceneSettings& settings, double share, double seconds) const;

  int needed_substeps_;
  Solvers solvers_{};
};

}  // namespace isochor
