#include "server/messages/report_request.h"

#include <fmt/format.h>

#include <limits>

#include "core/parameters/parameters.h"
#include "core/scene/read_scene.h"
#include "server/messages/object_reader.h"
#include "server/messages/report_messages.h"
#include "server/messages/request_messages.h"

namespace isochor {
namespace {

constexpr std::size_t max_axis = 32, max_points = 400;
constexpr int max_repeats = 20, max_refinement = 64;

/// A list of numbers, each in its range; nullopt when absent.
template <class T>
std::optional<std::vector<T>> read_axis(ObjectReader& reader, const std::string& name, AxisRange range) {
  const Json* list = reader.member(name);
  if (!list) return std::nullopt;
  std::vector<T> axis;
  if (!list->is_array() || list->size() > max_axis) {
    reader.fault(name, fmt::format("is not a list of up to {} values", max_axis));
    return axis;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& item = (*list)[i];
    const double value = item.is_number() ? item.get<double>() : std::numeric_limits<double>::quiet_NaN();
    const bool whole = !std::is_integral_v<T> || value == std::floor(value);
    if (value >= range.min && value <= range.max && whole)
      axis.push_back(static_cast<T>(value));
    else
      reader.fault(fmt::format("{}/{}", name, i), "is out of range, or not such a number", range.min,
                   range.max);
  }
  return axis;
}

/// The ranges are those of the table of parameters; absent: as it was.
template <class T>
void read_parameter_axis(ObjectReader& reader, const std::string& name, std::vector<T>& axis) {
  const Parameter* row = find_parameter(name);
  axis = read_axis<T>(reader, name, {row->min, row->max}).value_or(axis);
}

template <class T>
std::optional<std::vector<T>> read_names(ObjectReader& reader, const std::string& name,
                                         T (*value_of)(const std::string&)) {
  const Json* list = reader.member(name);
  if (!list) return std::nullopt;
  std::vector<T> axis;
  if (!list->is_array() || list->size() > max_axis) {
    reader.fault(name, fmt::format("is not a list of up to {} names", max_axis));
    return axis;
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& item = (*list)[i];
    try {
      axis.push_back(value_of(item.is_string() ? item.get<std::string>() : item.dump()));
    } catch (const Error& error) {
      reader.fault(fmt::format("{}/{}", name, i), error.what() + (": " + error.hint()));
    }
  }
  return axis;
}

void check_points(std::size_t points) {
  if (points <= max_points) return;
  throw Error(ErrorCode::over_budget, fmt::format("the grid has {} points", points),
              fmt::format("at most {} in one report: shorten its axes", max_points),
              {{"/axes", "are too long", {}, {}}});
}

/// A member that has a reader of its own, whose pointers then start here.
template <class Read>
auto read_below(const std::string& name, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    std::vector<ErrorDetail> details = error.details();
    for (ErrorDetail& detail : details) detail.pointer = "/" + name + detail.pointer;
    throw Error(error.code(), error.what(), error.hint(), std::move(details));
  }
}

std::variant<Scene, std::string> read_subject(ObjectReader& reader) {
  const auto sample = reader.text("sample");
  const Json* scene = reader.member("scene");
  if (sample.has_value() == (scene != nullptr)) {
    reader.fault(scene ? "sample" : "scene", scene ? "stands beside a scene" : "is missing");
    return std::string();
  }
  if (sample) return *sample;
  // An empty base keeps the names of meshes as they were given: they are looked up, never opened.
  return read_below("scene", [&] { return read_scene(to_text(*scene), ""); });
}

SceneReportRequest read_scene_report(ObjectReader& reader) {
  SceneReportRequest request{read_subject(reader), {}};
  SceneReportOptions& options = request.options;
  options.reference_refinement = static_cast<int>(
      reader.integer("refinement", 1, max_refinement).value_or(options.reference_refinement));
  options.point_limit = reader.number("point_limit", 1e-3, 1e6).value_or(options.point_limit);
  if (const Json* json = reader.member("axes")) {
    ObjectReader axes(*json, "/axes");
    options.axes = {read_names(axes, "solvers", solver_named), read_names(axes, "springs", springs_named),
                    read_axis<int>(axes, "substeps", substeps_range),
                    read_axis<double>(axes, "tolerances", tolerance_range),
                    read_axis<double>(axes, "resolutions", resolution_range)};
    axes.finish("axes");
  }
  check_points(most_points(options.axes));
  return request;
}

MeshReportRequest read_mesh_report(ObjectReader& reader) {
  MeshReportRequest request;
  MeshingReportOptions& options = request.options;
  request.mesh_id = reader.required("mesh_id", reader.text("mesh_id"));
  if (const Json* params = reader.member("params"))
    options.base = read_below("params", [&] { return read_meshing_options(to_text(*params)); });
  options.axes = usual_meshing_axes(options.base);
  if (const Json* json = reader.member("axes")) {
    ObjectReader axes(*json, "/axes");
    read_parameter_axis(axes, "voxels", options.axes.voxels);
    read_parameter_axis(axes, "cells", options.axes.cells);
    read_parameter_axis(axes, "smoothing_iterations", options.axes.smoothing_iterations);
    read_parameter_axis(axes, "p_in_voxels", options.axes.p_in_voxels);
    axes.finish("axes");
  }
  check_points(meshing_grid(options).size());
  return request;
}

}  // namespace

ReportRequest read_report_request(std::string_view text) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  ReportRequest request;
  const int repeats = static_cast<int>(reader.integer("repeats", 1, max_repeats).value_or(3));
  request.budget_ms = reader.number("budget_ms", 1e-3, 1e6);
  request.supersedes = reader.text("supersedes");
  switch (reader.required("kind", reader.choice("kind", {"scene", "mesh", "stability"}))) {
    case 0:
      request.subject = read_scene_report(reader);
      std::get<SceneReportRequest>(request.subject).options.repeats = repeats;
      break;
    case 1:
      request.subject = read_mesh_report(reader);
      std::get<MeshReportRequest>(request.subject).options.repeats = repeats;
      break;
    default:
      request.subject = StabilityRequest{reader.boolean("quick").value_or(false) ? StabilityExtent::quick
                                                                                 : StabilityExtent::full};
  }
  reader.finish("report");
  return request;
}

}  // namespace isochor
