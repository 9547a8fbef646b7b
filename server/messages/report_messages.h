#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/report/meshing_report.h"
#include "core/report/scene_report.h"
#include "core/report/stability.h"

namespace isochor {

/// {"kind":"scene", "scene", "complete", "machine", "compiler", "commit", "reference", "points":[{settings,
/// series, …}],
///  "fronts":{error:[indices of points]}, "orders":[…], "fields":[{name,label}]}. Not-a-number becomes null.
/// With a budget (ms a step) also "proposal": {"point", "solver", "resolution"}, null when no point fits.
/// source names the content that it is of, for those who resume it.
std::string encode_scene_report(const SceneReport& report, std::optional<double> budget_ms = {},
                                std::string_view source = {});
/// One row a point, the settings first.
std::string encode_scene_csv(const SceneReport& report);
/// An encoded report, to resume it: the reference and the points. Throws cannot_read, also when it is of
/// another source, machine, compiler or commit, so that its times and errors are not those of this one.
SceneReport decode_scene_report(std::string_view json, std::string_view source);
MeshingReport decode_meshing_report(std::string_view json, std::string_view source);

/// The proposal, within a budget for the whole of meshing: {"point", "params"}.
std::string encode_meshing_report(const MeshingReport& report, std::string_view input,
                                  std::optional<double> budget_ms = {}, std::string_view source = {});
std::string encode_meshing_csv(const MeshingReport& report);

std::string encode_stability(const StabilityReport& report);

/// The solver's settings as a params file of `simulate`: {"solver":{…},"resolution":…}.
std::string encode_settings(const SceneSettings& settings);
/// The scene with what a params file sets; other fields stay as they are. Throws cannot_read (syntax), and
/// invalid_argument that lists every faulty or unknown field.
Scene apply_params(const Scene& scene, std::string_view json);

/// Names as in scenes.
std::string_view solver_name(VolumeSolver solver);
std::string_view springs_name(SpringIntegrator springs);
std::string_view outcome_name(Outcome outcome);
/// Infeasible: there is a model, but an incomplete one.
Outcome outcome_of(const MeshingPoint& point);
/// Of a file that belongs to the point: no two points share it.
std::string point_name(const SceneSettings& settings);
/// What the points of one curve share: they differ in the step only.
std::string series_name(const SceneSettings& settings);
/// What all points of a fitted order have in common.
std::string series_name(const FittedOrder& order);
/// Throw invalid_argument.
VolumeSolver solver_named(const std::string& name);
SpringIntegrator springs_named(const std::string& name);

}  // namespace isochor
