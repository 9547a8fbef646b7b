#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/report/cost_model.h"
#include "core/scene/scene.h"

namespace isochor {

/// One point of the grid solver × step × tolerance × resolution.
struct SceneSettings {
  VolumeSolver solver = VolumeSolver::newton;
  SpringIntegrator springs = SpringIntegrator::automatic;
  int substeps = 0;  ///< a frame; 0: as many as stability asks for
  double tolerance = 1e-6;
  double resolution = 1.0;  ///< factor on the cells of every deformable body's lattice
  bool operator==(const SceneSettings&) const = default;
};

/// What an axis may hold.
struct AxisRange {
  double min, max;
};
inline constexpr AxisRange substeps_range{0, 1000}, tolerance_range{1e-12, 1e-1}, resolution_range{0.125, 8};

/// The axes. An empty one takes the scene's own value, nullopt what is usual: all solvers, the scene's own
/// springs, tolerances of 1e-2, 1e-4 and its own, its cells and half of them, or a share close to that which
/// leaves the bodies their shapes, and of substeps once, twice, four and eight times those that it takes, the
/// latter up to 64. Where its springs are stepped implicitly because symplectic Euler needs more, up to 256,
/// once, twice and four times these as well.
struct SceneAxes {
  std::optional<std::vector<VolumeSolver>> solvers;
  std::optional<std::vector<SpringIntegrator>> springs;
  std::optional<std::vector<int>> substeps;
  std::optional<std::vector<double>> tolerances, resolutions;
};

/// These settings as the scene is stepped by them: with the integrator that `automatic` chooses (unless the
/// bodies differ in it), and the substeps that are asked for or more, where stability asks for more. What
/// nothing in the scene goes by is the scene's own: without a deformable body all but the substeps.
using AsStepped = std::function<SceneSettings(const SceneSettings&)>;

/// Why the resolution is no axis of this scene's grid unless somebody asks for one; empty where it is, or
/// where nothing has cells.
std::string why_one_lattice(const Scene& scene);

/// The points as they are stepped, so that those which would be the same run stand there once.
std::vector<SceneSettings> scene_grid(const Scene& scene, const SceneAxes& axes, const AsStepped& as_stepped);

/// For predicting what a run takes: its cost goes as the substeps and as the cells, and more or less as the
/// decades of the tolerance.
CostPlace cost_place(const SceneSettings& settings);

/// No grid over these axes has more points, whatever the scene.
std::size_t most_points(const SceneAxes& axes);

/// The scene with these settings. A lattice body's cell_size is divided as its cells are multiplied, its
/// springs keep their modulus E = k/cell_size. Throws invalid_argument when a resolution leaves a lattice no
/// whole cells, or another one of a meshed body meets springs in N/m.
Scene apply_settings(const Scene& scene, const SceneSettings& settings);

}  // namespace isochor
