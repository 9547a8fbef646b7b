#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/parameters/parameters.h"
#include "core/scene/read_body.h"
#include "core/scene/read_scene.h"

namespace isochor {
namespace {

std::optional<ParameterValue> to_value(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_unsigned() && json.get<std::uint64_t>() > INT64_MAX) return json.get<double>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  return std::nullopt;
}

MeshingOptions options_of_preset(const Json& name, const std::string& pointer,
                                 std::vector<ErrorDetail>& faults) {
  for (const Preset& preset : meshing_presets())
    if (name == preset.name) return preset_options(preset.name);
  std::string known;
  for (const Preset& preset : meshing_presets())
    known += (known.empty() ? "" : ", ") + std::string(preset.name);
  faults.push_back({pointer, "must be one of " + known, {}, {}});
  return {};
}

}  // namespace

MeshingOptions read_meshing(const Json& json, const std::string& pointer, std::vector<ErrorDetail>& faults) {
  MeshingOptions options;
  if (!json.is_object()) {
    faults.push_back({pointer, "must be an object", {}, {}});
    return options;
  }
  std::vector<NamedValue> values;
  if (json.contains("preset")) options = options_of_preset(json["preset"], pointer + "/preset", faults);
  for (const auto& [name, value] : json.items()) {
    if (name == "preset") continue;
    if (auto read = to_value(value))
      values.emplace_back(name, *read);
    else
      faults.push_back(
          {fmt::format("{}/{}", pointer, name), "must be a number, a string, true or false", {}, {}});
  }
  try {
    set_parameters(options, values);
  } catch (const Error& error) {
    for (ErrorDetail detail : error.details()) {
      detail.pointer = pointer + detail.pointer;
      faults.push_back(std::move(detail));
    }
  }
  return options;
}

MeshingOptions read_meshing_options(std::string_view json) {
  std::vector<ErrorDetail> faults;
  const MeshingOptions options = read_meshing(parse_json(json, "the parameters"), "", faults);
  throw_faults("the parameters", std::move(faults));
  return options;
}

std::string write_meshing_options(const MeshingOptions& options) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Parameter& row : meshing_parameters()) {
    if (const auto value = row.get(options))
      std::visit([&](const auto& v) { json[std::string(row.name)] = v; }, *value);
  }
  return json.dump(2);
}

}  // namespace isochor
