#include "server/messages/report_messages.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <ctime>
#include <utility>

#include "core/parallel/parallel.h"
#include "core/scene/read_scene.h"
#include "server/build_info.h"
#include "server/messages/json.h"
#include "server/messages/model_messages.h"
#include "server/messages/object_reader.h"
#include "server/messages/request_messages.h"

namespace isochor {
namespace {

template <class T, std::size_t N>
using Names = std::array<std::pair<T, std::string_view>, N>;

constexpr Names<VolumeSolver, 3> solver_names{{{VolumeSolver::newton, "newton"},
                                               {VolumeSolver::scaling, "scaling"},
                                               {VolumeSolver::gradient, "gradient"}}};
constexpr Names<SpringIntegrator, 4> springs_names{{{SpringIntegrator::automatic, "auto"},
                                                    {SpringIntegrator::symplectic, "symplectic"},
                                                    {SpringIntegrator::implicit, "implicit"},
                                                    {SpringIntegrator::energy_momentum, "energy_momentum"}}};
constexpr Names<Outcome, 5> outcome_names{{{Outcome::converged, "converged"},
                                           {Outcome::infeasible, "infeasible"},
                                           {Outcome::blew_up, "blew_up"},
                                           {Outcome::too_slow, "too_slow"},
                                           {Outcome::failed, "failed"}}};

template <class T, std::size_t N>
std::string_view name_of(const Names<T, N>& names, T value) {
  for (const auto& [known, name] : names)
    if (known == value) return name;
  return "unknown";
}

template <class T, std::size_t N>
std::string known_names(const Names<T, N>& names) {
  std::string list = "use one of";
  for (const auto& [value, name] : names) list += " " + std::string(name);
  return list;
}

template <class T, std::size_t N>
T value_of(const Names<T, N>& names, const std::string& wanted) {
  for (const auto& [value, name] : names)
    if (name == wanted) return value;
  throw Error(ErrorCode::invalid_argument, "\"" + wanted + "\" is not known", known_names(names));
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
double number_from(const Json& json) {
  return json.is_number() ? json.get<double>() : not_measured;
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  return fmt::format("{:%FT%TZ}", parts);
}

Json provenance(std::string_view kind, bool complete, std::string_view source = {}) {
  const BuildInfo& info = build_info();
  return {{"kind", kind},
          {"complete", complete},
          {"source", source},
          {"machine", info.machine},
          {"threads", thread_count()},
          {"made", now_utc()},
          {"compiler", info.compiler},
          {"version", info.version},
          {"commit", info.commit}};
}

Json to_json(const Spread& spread) {
  return {{"median", number(spread.median)}, {"min", number(spread.min)}, {"max", number(spread.max)}};
}

Spread spread_from(const Json& json) {
  return {number_from(json.at("median")), number_from(json.at("min")), number_from(json.at("max"))};
}

Json to_json(const SceneSettings& settings) {
  return {{"solver", solver_name(settings.solver)},
          {"springs", springs_name(settings.springs)},
          {"substeps", settings.substeps},
          {"tolerance", settings.tolerance},
          {"resolution", settings.resolution}};
}

/// Points that differ in the lattice only are one curve.
std::string series_name(const MeshingOptions& options) {
  return fmt::format("{} voxels · P_in {:g} · {} × smoothed", options.voxels,
                     options.pseudo_volume.p_in_voxels, options.smoothing.iterations);
}

Json to_json(const ScenePoint& point) {
  Json errors;
  for (const SceneErrorField& field : scene_error_fields())
    errors[std::string(field.name)] = number(point.errors.*field.value);
  return {{"name", point_name(point.settings)},
          {"settings", to_json(point.settings)},
          {"series", series_name(point.settings)},
          {"outcome", outcome_name(point.outcome)},
          {"reason", point.reason},
          {"errors", std::move(errors)},
          {"ms_per_step", to_json(point.ms_per_step)},
          {"ms_p95", number(point.ms_p95)},
          {"fits_ms", number(point.fits_ms())},
          {"runs", point.runs},
          {"seconds", number(point.seconds)},
          {"substeps", point.substeps},
          {"cells", point.cells},
          {"recoveries", point.recoveries},
          {"fallbacks", point.fallbacks}};
}

SceneSettings settings_from(const Json& json) {
  return {value_of(solver_names, json.at("solver")), value_of(springs_names, json.at("springs")),
          json.at("substeps"), json.at("tolerance"), json.at("resolution")};
}

ScenePoint scene_point_from(const Json& json) {
  ScenePoint point;
  point.settings = settings_from(json.at("settings"));
  point.outcome = value_of(outcome_names, json.at("outcome"));
  point.reason = json.at("reason");
  for (const SceneErrorField& field : scene_error_fields())
    point.errors.*field.value = number_from(json.at("errors").at(std::string(field.name)));
  point.ms_per_step = spread_from(json.at("ms_per_step"));
  point.ms_p95 = number_from(json.at("ms_p95"));
  point.seconds = number_from(json.at("seconds"));
  point.runs = json.at("runs");
  point.substeps = json.at("substeps"), point.cells = json.at("cells");
  point.recoveries = json.at("recoveries"), point.fallbacks = json.at("fallbacks");
  return point;
}

MeshingPoint meshing_point_from(const Json& json) {
  MeshingPoint point;
  point.options = read_meshing_options(to_text(json.at("settings")));
  const bool failed = json.at("outcome") == outcome_name(Outcome::failed);
  (failed ? point.problem : point.incomplete) = json.at("reason");
  QualitySummary& q = point.quality;
  q.boundary_to_input = number_from(json.at("errors").at("boundary_to_input"));
  q.input_to_boundary = number_from(json.at("errors").at("input_to_boundary"));
  q.to_pseudo_volume = {number_from(json.at("max_diagonals_to_pseudo_volume")),
                        number_from(json.at("mean_diagonals_to_pseudo_volume"))};
  q.volume = number_from(json.at("volume")), q.coverage = number_from(json.at("coverage"));
  q.min_dihedral_deg = number_from(json.at("min_dihedral_deg"));
  q.min_scaled_jacobian = number_from(json.at("min_scaled_jacobian"));
  if (json.at("inverted").is_number()) q.inverted = json.at("inverted");
  if (json.at("volume_error").is_number()) point.volume_error = json.at("volume_error");
  point.tets = json.at("tets"), point.cells = json.at("cells");
  point.ms = spread_from(json.at("ms_per_step"));
  return point;
}

/// What has to be the same for two runs to stand in one report.
void check_provenance(const Json& report, const Json& ours) {
  for (const char* what : {"kind", "source", "machine", "threads", "compiler", "commit"})
    if (report.at(what) != ours.at(what))
      throw Error(ErrorCode::cannot_read,
                  fmt::format("the report to resume has another {}: {}, not {}", what, report.at(what).dump(),
                              ours.at(what).dump()),
                  "run it afresh, without --resume");
}

template <class Report, class Point>
Report decode_report(std::string_view text, const Json& ours, Point (*decode)(const Json&)) {
  try {
    Report report;
    const Json json = Json::parse(text);
    check_provenance(json, ours);
    for (const Json& point : json.at("points")) try {
        report.points.push_back(decode(point));
      } catch (const Error&) {
        // Settings out of range: it failed for them, and fails again where it is asked for.
        if (point.at("outcome") != outcome_name(Outcome::failed)) throw;
      }
    if constexpr (std::is_same_v<Report, SceneReport>)
      report.reference = scene_point_from(json.at("reference"));
    return report;
  } catch (const Json::exception& fault) {
    throw Error(ErrorCode::cannot_read,
                std::string("the report to resume is not one of ours: ") + fault.what(),
                "run it afresh, without --resume");
  }
}

template <class T, std::size_t N>
void read_name(ObjectReader& reader, const std::string& field, const Names<T, N>& names, T& target) {
  std::vector<std::string_view> choices;
  for (const auto& [value, name] : names) choices.push_back(name);
  if (const auto index = reader.choice(field, choices)) target = names[*index].first;
}

/// {error: [indices of points]}, from encoded points. Those that blew up or failed have no place on a front.
Json fronts(const Json& fields, const Json& points) {
  Json result = Json::object();
  for (const Json& field : fields) {
    const std::string name = field.at("name");
    std::vector<double> cost, error;
    for (const Json& point : points) {
      const bool usable = point.at("outcome") == "converged" || point.at("outcome") == "infeasible";
      cost.push_back(usable ? number_from(point.at("ms_per_step").at("median")) : not_measured);
      error.push_back(number_from(point.at("errors").at(name)));
    }
    result[name] = pareto_front(cost, error);
  }
  return result;
}

/// Empty where there is none.
std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

/// RFC 4180: quoted where a comma, a quote or a line end stands in it.
std::string csv_text(std::string_view text) {
  if (text.find_first_of(",\"\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

/// As a scene has them.
Json settings_json(const SceneSettings& settings) {
  return {{"solver",
           {{"volume", solver_name(settings.solver)},
            {"springs", springs_name(settings.springs)},
            {"substeps", settings.substeps > 0 ? Json(settings.substeps) : Json("auto")},
            {"tolerance", settings.tolerance}}},
          {"resolution", settings.resolution}};
}

}  // namespace

std::string_view solver_name(VolumeSolver solver) {
  return name_of(solver_names, solver);
}
std::string_view springs_name(SpringIntegrator springs) {
  return name_of(springs_names, springs);
}
std::string_view outcome_name(Outcome outcome) {
  return name_of(outcome_names, outcome);
}

Outcome outcome_of(const MeshingPoint& point) {
  if (!point.problem.empty()) return Outcome::failed;
  return point.incomplete.empty() ? Outcome::converged : Outcome::infeasible;
}

std::string point_name(const SceneSettings& s) {
  return fmt::format("{}-{}-{}-{}-x{}", solver_name(s.solver), springs_name(s.springs), s.substeps,
                     s.tolerance, s.resolution);
}

std::string series_name(const SceneSettings& s) {
  std::string name =
      fmt::format("{} · {} · {:.0e}", solver_name(s.solver), springs_name(s.springs), s.tolerance);
  return s.resolution == 1.0 ? name : name + fmt::format(" · ×{:g}", s.resolution);
}

std::string series_name(const FittedOrder& order) {
  const SceneSettings& s = order.series;
  std::string name = fmt::format("{} · {}", solver_name(s.solver), springs_name(s.springs));
  if (order.axis != "tolerance") name += fmt::format(" · {:.0e}", s.tolerance);
  if (order.axis != "h" && s.substeps > 0) name += fmt::format(" · {} substeps", s.substeps);
  if (order.axis != "cell_size" && s.resolution != 1.0) name += fmt::format(" · ×{:g}", s.resolution);
  return name;
}

VolumeSolver solver_named(const std::string& name) {
  return value_of(solver_names, name);
}
SpringIntegrator springs_named(const std::string& name) {
  return value_of(springs_names, name);
}

std::string encode_scene_report(const SceneReport& report, std::optional<double> budget_ms,
                                std::string_view source) {
  Json json = provenance("scene", report.complete, source);
  json["scene"] = report.scene;
  json["reference"] = to_json(report.reference);
  json["one_lattice"] = report.one_lattice;
  json["fields"] = Json::array();
  for (const SceneErrorField& field : scene_error_fields())
    json["fields"].push_back(
        {{"name", field.name}, {"label", field.label}, {"floor", number(error_floor(report, field))}});
  json["points"] = Json::array();
  for (const ScenePoint& point : report.points) json["points"].push_back(to_json(point));
  json["fronts"] = fronts(json["fields"], json["points"]);
  json["orders"] = Json::array();
  for (const FittedOrder& order : fitted_orders(report))
    json["orders"].push_back({{"error", order.error},
                              {"axis", order.axis},
                              {"series", series_name(order)},
                              {"order", number(order.order)},
                              {"points", order.points}});
  if (budget_ms) {
    const ScenePoint* best = fit_budget(report, *budget_ms);
    json["budget_ms"] = *budget_ms;
    json["proposal"] = nullptr;
    if (best) {
      json["proposal"] = {{"point", best - report.points.data()}};
      json["proposal"].update(settings_json(best->settings));
    }
  }
  return json.dump(1) + '\n';
}

std::string encode_scene_csv(const SceneReport& report) {
  std::string csv = "solver,springs,substeps,tolerance,resolution,outcome";
  for (const SceneErrorField& field : scene_error_fields()) csv += fmt::format(",{}", field.name);
  csv += ",ms_per_step,ms_min,ms_max,ms_p95,runs,seconds,max_substeps,cells,recoveries,fallbacks,reason\n";
  for (const ScenePoint& p : report.points) {
    csv += fmt::format("{},{},{},{},{},{}", solver_name(p.settings.solver), springs_name(p.settings.springs),
                       p.settings.substeps, p.settings.tolerance, p.settings.resolution,
                       outcome_name(p.outcome));
    for (const SceneErrorField& field : scene_error_fields()) csv += ',' + csv_number(p.errors.*field.value);
    for (double time : {p.ms_per_step.median, p.ms_per_step.min, p.ms_per_step.max, p.ms_p95})
      csv += ',' + csv_number(time);
    csv += fmt::format(",{},{},{},{},{},{},{}\n", p.runs, csv_number(p.seconds), p.substeps, p.cells,
                       p.recoveries, p.fallbacks, csv_text(p.reason));
  }
  return csv;
}

SceneReport decode_scene_report(std::string_view json, std::string_view source) {
  return decode_report<SceneReport>(json, provenance("scene", false, source), scene_point_from);
}

MeshingReport decode_meshing_report(std::string_view json, std::string_view source) {
  return decode_report<MeshingReport>(json, provenance("meshing", false, source), meshing_point_from);
}

std::string encode_meshing_report(const MeshingReport& report, std::string_view input,
                                  std::optional<double> budget_ms, std::string_view source) {
  Json json = provenance("meshing", report.complete, source);
  json["input"] = input;
  json["fields"] = {
      {{"name", "distance"}, {"label", "distance between boundary and input, the larger way"}},
      {{"name", "boundary_to_input"}, {"label", "distance from the boundary to the input"}},
      {{"name", "input_to_boundary"}, {"label", "distance from the input to the model, 0 within"}},
      {{"name", "volume"}, {"label", "volume error (closed input)"}}};
  json["points"] = Json::array();
  for (const MeshingPoint& p : report.points) {
    const QualitySummary& q = p.quality;
    json["points"].push_back(
        {{"settings", parameters_json(p.options)},
         {"series", series_name(p.options)},
         {"outcome", outcome_name(outcome_of(p))},
         {"reason", p.problem.empty() ? p.incomplete : p.problem},
         {"errors",
          {{"distance", number(p.distance())},
           {"boundary_to_input", number(q.boundary_to_input)},
           {"input_to_boundary", number(q.input_to_boundary)},
           {"volume", p.volume_error ? number(std::abs(*p.volume_error)) : Json(nullptr)}}},
         {"ms_per_step", to_json(p.ms)},
         {"fits_ms", number(p.fits_ms())},
         {"cells", p.cells},
         {"tets", p.tets},
         {"volume", number(q.volume)},
         {"volume_error", p.volume_error ? number(*p.volume_error) : Json(nullptr)},
         {"max_diagonals_to_pseudo_volume", number(q.to_pseudo_volume.max_diagonals)},
         {"mean_diagonals_to_pseudo_volume", number(q.to_pseudo_volume.mean_diagonals)},
         {"coverage", number(q.coverage)},
         {"min_dihedral_deg", number(q.min_dihedral_deg)},
         {"min_scaled_jacobian", number(q.min_scaled_jacobian)},
         {"inverted", p.problem.empty() ? Json(q.inverted) : Json()}});
  }
  json["fronts"] = fronts(json["fields"], json["points"]);
  json["orders"] = Json::array();
  if (budget_ms) {
    const MeshingPoint* best = fit_budget(report, *budget_ms);
    json["budget_ms"] = *budget_ms;
    json["proposal"] =
        best ? Json{{"point", best - report.points.data()}, {"params", parameters_json(best->options)}}
             : Json();
  }
  return json.dump(1) + '\n';
}

std::string encode_meshing_csv(const MeshingReport& report) {
  std::string csv =
      "voxels,p_in_voxels,cells,smoothing_iterations,lattice_cells,tets,ms,ms_min,ms_max,volume,volume_error,"
      "boundary_to_input,input_to_boundary,max_diagonals_to_pseudo_volume,mean_diagonals_to_pseudo_volume,"
      "coverage,min_dihedral_deg,inverted,outcome,reason\n";
  for (const MeshingPoint& p : report.points) {
    const QualitySummary& q = p.quality;
    csv += fmt::format("{},{},{},{},{},{}", p.options.voxels, p.options.pseudo_volume.p_in_voxels,
                       p.options.lattice.cells, p.options.smoothing.iterations, p.cells, p.tets);
    for (double figure : {p.ms.median, p.ms.min, p.ms.max, q.volume, p.volume_error.value_or(NAN),
                          q.boundary_to_input, q.input_to_boundary, q.to_pseudo_volume.max_diagonals,
                          q.to_pseudo_volume.mean_diagonals, q.coverage, q.min_dihedral_deg})
      csv += ',' + csv_number(figure);
    csv += fmt::format(",{},{},{}\n", p.problem.empty() ? fmt::format("{}", q.inverted) : "",
                       outcome_name(outcome_of(p)), csv_text(p.problem.empty() ? p.incomplete : p.problem));
  }
  return csv;
}

std::string encode_stability(const StabilityReport& report) {
  Json json = provenance("stability", report.complete);
  json["passed"] = report.passed();
  json["cases"] = Json::array();
  for (const StabilityResult& r : report.results) {
    Json row{{"group", r.group},
             {"name", r.name},
             {"passed", r.passed},
             {"outcome", r.outcome},
             {"tolerance", r.tolerance},
             {"max_cell_volume_error", number(r.max_cell_volume_error)},
             {"total_volume_error", number(r.total_volume_error)},
             {"energy_ratio", number(r.energy_ratio)},
             {"momentum_drift", number(r.momentum_drift)},
             {"inverted", r.inverted},
             {"recoveries", r.recoveries},
             {"fallbacks", r.fallbacks},
             {"seconds", number(r.seconds)}};
    if (r.h > 0.0) row["stiffness"] = r.stiffness, row["h"] = r.h;
    json["cases"].push_back(std::move(row));
  }
  return json.dump(1) + '\n';
}

std::string encode_settings(const SceneSettings& settings) {
  return settings_json(settings).dump(1) + '\n';
}

Scene apply_params(const Scene& scene, std::string_view text) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  SceneSettings settings{scene.solver.volume, scene.solver.springs, scene.solver.substeps,
                         scene.solver.tolerance, 1.0};
  if (const Json* object = reader.member("solver")) {
    ObjectReader solver(*object, "/solver");
    read_name(solver, "volume", solver_names, settings.solver);
    read_name(solver, "springs", springs_names, settings.springs);
    settings.tolerance = solver.number("tolerance", 1e-12, 1e-1).value_or(settings.tolerance);
    const Json* substeps = solver.member("substeps");
    if (substeps && *substeps == "auto")
      settings.substeps = 0;
    else
      settings.substeps = static_cast<int>(solver.integer("substeps", 1, 100000).value_or(settings.substeps));
    solver.finish("params");
  }
  settings.resolution = reader.number("resolution", 0.125, 8.0).value_or(1.0);
  reader.finish("params");
  return apply_settings(scene, settings);
}

}  // namespace isochor
