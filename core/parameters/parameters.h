#pragma once
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/pipeline/pipeline.h"

namespace isochor {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// One row of the table of parameters: the source of the command line's options, the API's JSON Schema, the
/// page's controls and the docs.
struct Parameter {
  std::string_view name;     ///< snake_case in JSON, --kebab-case on the command line
  std::string_view title;    ///< label on the page
  std::string_view unit;     ///< "voxels", "" for none
  std::string_view stage;    ///< first stage that it makes stale
  std::string_view meaning;  ///< one sentence, with the consequence of more and less
  enum class Type { boolean, integer, number, choice } type;
  double min = 0.0, max = 0.0, step = 0.0;  ///< numbers only
  std::vector<std::string_view> choices;    ///< choice only
  ParameterValue fallback;                  ///< the default, read from a default-constructed options struct
  bool optional = false;                    ///< may be absent (p_in, p_subs: the probability form)
  std::function<std::optional<ParameterValue>(const MeshingOptions&)> get;
  std::function<void(MeshingOptions&, const ParameterValue&)> set;
};

std::span<const Parameter> meshing_parameters();
const Parameter* find_parameter(std::string_view name);

/// Named sets of values, e.g. "thin" for sheets and foliage.
struct Preset {
  std::string_view name, title, meaning;
  std::vector<std::pair<std::string_view, ParameterValue>> values;
};
std::span<const Preset> meshing_presets();

/// Throws invalid_argument that lists every faulty field with its range (pointer "/name").
void set_parameter(MeshingOptions& options, std::string_view name, const ParameterValue& value);
void validate(const MeshingOptions& options);

}  // namespace isochor
