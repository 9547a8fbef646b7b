#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/pipeline/pipeline.h"

namespace isochor {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;
using NamedValue = std::pair<std::string, ParameterValue>;

/// One row of the table of parameters: the source of the command line's options, the API's JSON Schema, the
/// page's controls and the docs.
struct Parameter {
  std::string_view name;     ///< snake_case in JSON, --kebab-case on the command line
  std::string_view title;    ///< label on the page
  std::string_view unit;     ///< "voxels", "" for none
  std::string_view stage;    ///< first stage that it makes stale
  std::string_view meaning;  ///< one sentence, with the consequence of more and less
  enum class Type { boolean, integer, number, choice } type;
  double min = 0.0, max = 0.0, step = 0.0;     ///< numbers only
  std::vector<std::string_view> choices = {};  ///< of a choice; of an integer that has only a few values
  ParameterValue fallback = {};  ///< the default, read from a default-constructed options struct
  bool optional = false;         ///< may be absent (p_in, p_subs: the probability form)
  /// nullopt when absent. Of p_in and p_in_voxels (p_subs and p_subs_voxels) exactly one is present.
  std::function<std::optional<ParameterValue>(const MeshingOptions&)> get = {};
  /// Unchecked; set_parameter checks first. Setting one form of a threshold clears the other.
  std::function<void(MeshingOptions&, const ParameterValue&)> set = {};
};

std::span<const Parameter> meshing_parameters();
const Parameter* find_parameter(std::string_view name);

/// Named sets of values, e.g. "thin" for sheets and foliage. They start from the defaults.
struct Preset {
  std::string_view name, title, meaning;
  std::vector<NamedValue> values;
};
std::span<const Preset> meshing_presets();
/// Throws invalid_argument that names the presets.
MeshingOptions preset_options(std::string_view name);

/// What is wrong with a value for this row: type, range or choice. An integral double counts as an integer.
std::optional<ErrorDetail> check_value(const Parameter& parameter, const ParameterValue& value);

/// Throws invalid_argument that lists every faulty or unknown field with its range (pointer "/name").
void set_parameter(MeshingOptions& options, std::string_view name, const ParameterValue& value);
/// Whether the cells are as the options say, or are sought by what follows: then, unless they are among the
/// values, no more of them stand in the options than the voxels allow.
enum class Cells { given, sought };
/// Sets in the order of the table whatever the order given, then validates the whole; options stay as they
/// were when it throws.
void set_parameters(MeshingOptions& options, std::span<const NamedValue> values, Cells cells = Cells::given);
/// Ranges, and the relations between fields: cells ≤ voxels/2, p_subs beyond p_in.
void validate(const MeshingOptions& options);

/// "voxels=128 p_in_voxels=1 …": every present value in table order, for comments in files and logs.
std::string describe(const MeshingOptions& options);

}  // namespace isochor
