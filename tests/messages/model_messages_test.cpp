#include "server/messages/model_messages.h"

#include <gtest/gtest.h>

#include "core/export/export.h"

namespace isochor {
namespace {

ParameterValue parameter_value(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number()) return json.get<double>();
  return json.get<std::string>();
}

TEST(ParametersSchema, HasEveryRowInOrderWithItsDefaultAndRange) {
  const Json schema = parameters_schema();
  EXPECT_FALSE(schema["additionalProperties"].get<bool>());
  auto property = schema["properties"].begin();
  for (const Parameter& row : meshing_parameters()) {
    ASSERT_EQ(property.key(), row.name);
    const Json& json = property.value();
    EXPECT_EQ(json["title"], row.title);
    EXPECT_EQ(json["x-stage"], row.stage);
    EXPECT_EQ(json.contains("default"), !row.optional);
    if (json.contains("default")) {
      EXPECT_EQ(parameter_value(json["default"]), row.fallback) << row.name;
    }
    EXPECT_EQ(json.contains("enum"), !row.choices.empty());
    if (json.contains("minimum")) {
      EXPECT_LT(json["minimum"].get<double>(), json["maximum"].get<double>());
    }
    ++property;
  }
  EXPECT_EQ(schema["properties"]["rays"]["enum"], Json::parse("[6,14,26]"));
  EXPECT_EQ(schema["properties"]["voxels"]["maximum"].dump(), "512") << "whole, without a fraction";
}

TEST(ParametersSchema, PresetsAreAcceptedAsTheyStand) {
  const Json schema = parameters_schema();
  for (const Json& preset : schema["x-presets"]) {
    MeshingOptions options;
    for (const auto& [name, value] : preset["values"].items())
      EXPECT_NO_THROW(set_parameter(options, name, parameter_value(value))) << name;
    EXPECT_EQ(options, preset_options(preset["name"].get<std::string>()));
  }
}

TEST(ParametersJson, ReadsBackTheSameOptions) {
  MeshingOptions options = preset_options("hull");
  set_parameter(options, "p_in", 0.95);
  std::vector<NamedValue> values;
  const Json written = parameters_json(options);
  for (const auto& [name, value] : written.items()) values.emplace_back(name, parameter_value(value));
  MeshingOptions read;
  set_parameters(read, values);
  EXPECT_EQ(parameters_json(read), written);
  EXPECT_FALSE(written.contains("p_in_voxels")) << "one form of a threshold only";
}

TEST(MeshReportJson, ListsDefectsWithTheirPlaces) {
  MeshReport report;
  report.triangles = 12;
  report.bounds.extend(Vec3(0, 1, 2));
  report.defects.push_back({"open_edges", 3, {Vec3(0, 1, 2)}});
  const Json json = mesh_report_json(report);
  EXPECT_EQ(json["triangles"], 12);
  EXPECT_EQ(json["defects"][0]["name"], "open_edges");
  EXPECT_EQ(json["defects"][0]["locations"].dump(), "[[0.0,1.0,2.0]]");
}

TEST(ExportFormatsJson, ListsTheTable) {
  const Json formats = export_formats_json();
  ASSERT_EQ(formats.size(), export_formats().size());
  EXPECT_EQ(formats[0]["name"], "msh2");
  for (const Json& format : formats) EXPECT_FALSE(format["consumers"].get<std::string>().empty());
}

TEST(ToText, SurvivesBytesThatAreNotUtf8) {
  EXPECT_EQ(to_text(Json{{"name", "a\xff"}}), "{\"name\":\"a\xEF\xBF\xBD\"}");
}

}  // namespace
}  // namespace isochor
