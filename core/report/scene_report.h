#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/common/progress.h"
#include "core/report/fit.h"
#include "core/report/scene_settings.h"
#include "core/scene/snapshot.h"

namespace isochor {

class Simulation;

/// Errors over a run; lengths in metres, "max" over frames 1 to the last. M and L are the mass and the extent
/// of the deformable bodies (where there are none, of the rigid ones that have a mass), T the scene's
/// duration.
struct SceneErrors {
  double max_cell_volume = 0.0;  ///< largest |V − V0|/V0 of a cell
  double total_volume = 0.0;     ///< largest |ΣV − ΣV0|/ΣV0
  double trajectory_rms = 0.0;   ///< over material points and frames, distance from the reference
  double trajectory_max = 0.0;
  double linear_momentum = 0.0;   ///< largest |p − p_ref| / max(|p_ref|, M·L/T)
  double angular_momentum = 0.0;  ///< largest |L − L_ref| / max(|L_ref|, M·L²/T)
  double energy = 0.0;            ///< largest |E − E_ref| / max(max E_ref − min E_ref, max kinetic E_ref)
  double max_penetration = 0.0;
};

/// The one table of the errors: JSON, CSV, the curves and the fitted orders all go through it.
struct SceneErrorField {
  std::string_view name, label;
  double SceneErrors::*value;
  bool of_reference;  ///< measured against the reference, so no better than it is
};
std::span<const SceneErrorField> scene_error_fields();

enum class Outcome {
  converged,   ///< every frame met the tolerance
  infeasible,  ///< finite, but a frame fell short of the tolerance
  blew_up,     ///< a position is not finite or a thousand times the scene's size away, or as much energy came
               ///< from nowhere
  too_slow,    ///< stopped at the limit of a run
  failed,      ///< could not be compiled
};
/// Whether a run reached the end of its scene, and so has errors that can be compared.
constexpr bool ended(Outcome outcome) {
  return outcome == Outcome::converged || outcome == Outcome::infeasible;
}

struct ScenePoint {
  SceneSettings settings;
  Outcome outcome = Outcome::converged;
  std::string reason;  ///< one sentence when not converged
  SceneErrors errors;
  Spread ms_per_step;    ///< a frame's worth of simulation: median over the frames, spread over the repeats
  double ms_p95 = 0.0;   ///< what 95 % of the frames of the slowest repeat stay within
  double seconds = 0.0;  ///< simulating the whole run, median of the repeats
  int runs = 0;          ///< that the spread is of: the repeats, or one of a slow point
  int substeps = 0;      ///< largest of a frame
  std::int64_t cells = 0, recoveries = 0, fallbacks = 0;

  double fits_ms() const { return fitting_budget(ms_p95); }
};

struct SceneReport {
  std::string scene;
  ScenePoint reference;  ///< what the errors are measured against; its own are those at half its substeps
  std::vector<ScenePoint> points;
  bool complete = true;     ///< false when cancelled: what was done is here
  std::string one_lattice;  ///< why the resolution is no axis, where nobody asked for one; empty where it is
};

struct SceneReportOptions {
  SceneAxes axes;
  int repeats = 3;
  /// Seconds after which a run of a point is stopped; the reference has no limit.
  double point_limit = std::numeric_limits<double>::infinity();
  int reference_refinement = 16;  ///< substeps of the reference over the largest of the grid
  double reference_tolerance = 1e-10;
  int material_points = 256;  ///< followed a body
  /// Makes the simulation of one point; empty: scene/compile.
  std::function<std::unique_ptr<Simulation>(const Scene&, Progress&)> build;
  /// An earlier run, whose points are all taken over, and its reference. Where the axes need a finer one,
  /// report_scene throws invalid_argument.
  SceneReport earlier;
  /// Called after each point, so that a caller can keep what is done.
  std::function<void(const SceneReport&)> on_point;
  /// Called at the start of a point's first repeat, and of the reference (without settings), then with each
  /// frame, then when there are no more, so that a caller can record them.
  std::function<void(const std::optional<SceneSettings>&, const Simulation&)> on_start;
  std::function<void(const Snapshot&)> on_frame;
  std::function<void()> on_end;
};

/// Before anything runs: throws invalid_argument when the scene has no end, over_budget when the material
/// points of the reference and of a run, frame by frame, would take more than max_bytes.
void check_scene_report(const Scene& scene, const SceneReportOptions& options, std::int64_t max_bytes);

/// Runs the grid against a reference at a far smaller step. Cancelling keeps what is done, and what an
/// earlier run did (complete = false). Progress is that of the whole, by the time that it took so far.
SceneReport report_scene(const Scene& scene, const SceneReportOptions& options, Progress& progress);

/// An order of convergence fitted over one axis, all other settings equal.
struct FittedOrder {
  std::string_view error;  ///< a SceneErrorField's name
  std::string_view axis;   ///< "h" (seconds a substep), "tolerance" or "cell_size" (relative)
  SceneSettings series;    ///< the settings that were equal; its value on the axis is that of the first point
  double order = 0.0;
  int points = 0;
};
/// Only over errors that can be told from round-off and from the reference's own; over cell_size not over
/// those on the reference's lattice, which share its error.
std::vector<FittedOrder> fitted_orders(const SceneReport& report);

/// What an error has to exceed to be told from round-off and from the error of the reference.
double error_floor(const SceneReport& report, const SceneErrorField& field);

/// The point with the smallest trajectory error that converged and fits the budget. Errors that cannot be
/// told from the reference's own are alike: there the smallest cell error counts, then the time.
const ScenePoint* fit_budget(const SceneReport& report, double budget_ms);

}  // namespace isochor
