#include "server/messages/model_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/export/export.h"
#include "core/pipeline/shortfall.h"

namespace isochor {
namespace {

Json value_json(const ParameterValue& value) {
  return std::visit([](const auto& v) { return Json(v); }, value);
}

/// Bounds of whole numbers are written without a fraction.
Json bound_json(const Parameter& row, double bound) {
  if (row.type == Parameter::Type::integer) return static_cast<std::int64_t>(bound);
  return bound;
}

Json choices_json(const Parameter& row) {
  Json choices = Json::array();
  for (const std::string_view choice : row.choices)
    choices.push_back(row.type == Parameter::Type::integer ? Json(std::stoll(std::string(choice)))
                                                           : Json(choice));
  return choices;
}

std::string_view type_name(Parameter::Type type) {
  switch (type) {
    case Parameter::Type::boolean:
      return "boolean";
    case Parameter::Type::integer:
      return "integer";
    case Parameter::Type::number:
      return "number";
    case Parameter::Type::choice:
      break;
  }
  return "string";
}

Json property_json(const Parameter& row) {
  Json property{{"title", row.title}, {"description", row.meaning}, {"type", type_name(row.type)}};
  const bool numeric = row.type == Parameter::Type::integer || row.type == Parameter::Type::number;
  if (!row.choices.empty()) {
    property["enum"] = choices_json(row);
  } else if (numeric) {
    property["minimum"] = bound_json(row, row.min);
    property["maximum"] = bound_json(row, row.max);
    property["x-step"] = bound_json(row, row.step);
  }
  if (!row.optional) property["default"] = value_json(row.fallback);
  property["x-unit"] = row.unit;
  property["x-stage"] = row.stage;
  return property;
}

Json preset_json(const Preset& preset) {
  Json values = Json::object();
  for (const auto& [name, value] : preset.values) values[name] = value_json(value);
  return {{"name", preset.name}, {"title", preset.title}, {"meaning", preset.meaning}, {"values", values}};
}

Json thresholds_json(const Thresholds& t) {
  return {{"p_in_voxels", t.p_in_voxels},
          {"p_subs_voxels", t.p_subs_voxels},
          {"p_in", t.p_in},
          {"p_subs", t.p_subs},
          {"d_in", t.d_in},
          {"d_subs", t.d_subs}};
}

Json stages_json(const Model& model) {
  Json stages = Json::array();
  for (const StageReport& stage : model.stages)
    stages.push_back({{"name", stage.name}, {"ms", stage.ms}, {"reused", stage.reused}});
  return stages;
}

Json fixes_json(const Model& model) {
  Json fixes = Json::array();
  for (const Fix& fix : model.fixes)
    fixes.push_back({{"warning", fix.warning}, {"parameter", fix.parameter}, {"value", fix.value}});
  return fixes;
}

}  // namespace

Json parameters_schema() {
  Json properties = Json::object(), presets = Json::array();
  for (const Parameter& row : meshing_parameters()) properties[row.name] = property_json(row);
  for (const Preset& preset : meshing_presets()) presets.push_back(preset_json(preset));
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "Meshing parameters"},
          {"type", "object"},
          {"additionalProperties", false},
          {"properties", std::move(properties)},
          {"x-presets", std::move(presets)}};
}

Json parameters_json(const MeshingOptions& options) {
  Json values = Json::object();
  for (const Parameter& row : meshing_parameters())
    if (const auto value = row.get(options)) values[row.name] = value_json(*value);
  return values;
}

Json mesh_report_json(const MeshReport& report) {
  Json defects = Json::array();
  for (const Defect& defect : report.defects) {
    Json locations = Json::array();
    for (const Vec3& location : defect.locations) locations.push_back(vec3_json(location));
    defects.push_back({{"name", defect.name}, {"count", defect.count}, {"locations", std::move(locations)}});
  }
  return {{"vertices", report.vertices},
          {"triangles", report.triangles},
          {"components", report.components},
          {"bounds", {{"min", vec3_json(report.bounds.min)}, {"max", vec3_json(report.bounds.max)}}},
          {"area", report.area},
          {"closed", report.closed},
          {"volume", report.volume},
          {"defects", std::move(defects)}};
}

Json model_json(const Model& model) {
  const TetMesh& mesh = model.mesh();
  const QualitySummary& quality = model.quality;
  const Lattice& lattice = *model.lattice;
  Json json = {{"cells", mesh.cells.size()},
               {"tets", mesh.tets.size()},
               {"vertices", mesh.positions.size()},
               {"surface_triangles", mesh.surface.size()},
               {"components", lattice.components},
               {"volume", quality.volume},
               {"inverted", quality.inverted},
               {"min_dihedral_deg", quality.min_dihedral_deg},
               {"min_scaled_jacobian", quality.min_scaled_jacobian},
               {"voxels_inside", model.pseudo_volume->inside_count},
               {"cell_size", lattice.grid.spacing},
               {"filled_cells", lattice.filled_count},
               {"edge_contacts", lattice.edge_contacts},
               {"vertex_contacts", lattice.vertex_contacts},
               {"largest_shrinkage", model.smoothed->largest_shrinkage},
               {"limited_vertices", model.smoothed->limited_vertices},
               {"thresholds", thresholds_json(model.pseudo_volume->thresholds)},
               {"params", parameters_json(model.options)},
               {"stages", stages_json(model)},
               {"quality_ms", model.quality_ms},
               {"warnings", model.warnings},
               {"fixes", fixes_json(model)}};
  if (model.embedding)
    json.update({{"coverage", quality.coverage},
                 {"complete", !shortfall(model)},
                 {"boundary_to_input", quality.boundary_to_input},
                 {"boundary_beyond", quality.boundary_beyond},
                 {"input_to_boundary", quality.input_to_boundary},
                 {"max_diagonals_to_pseudo_volume", quality.to_pseudo_volume.max_diagonals},
                 {"mean_diagonals_to_pseudo_volume", quality.to_pseudo_volume.mean_diagonals},
                 {"embedded_outside", model.embedding->outside}});
  return json;
}

Json estimate_json(const Estimate& estimate) {
  return {{"voxels", estimate.voxels},     {"cells", estimate.cells}, {"max_cells", estimate.max_cells},
          {"max_tets", estimate.max_tets}, {"bytes", estimate.bytes}, {"seconds", estimate.seconds}};
}

Json export_formats_json() {
  Json formats = Json::array();
  for (const ExportFormat& format : export_formats())
    formats.push_back({{"name", format.name},
                       {"extension", format.extension},
                       {"media_type", format.media_type},
                       {"consumers", format.consumers},
                       {"conventions", format.conventions}});
  return formats;
}

}  // namespace isochor
