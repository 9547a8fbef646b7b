#include "server/cli/parameter_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/scene/read_scene.h"
#include "server/cli/input.h"

namespace isochor {
namespace {

/// What is not a number stays text, and the table says that it must be one.
ParameterValue parse_value(const Parameter& row, const std::string& text) {
  if (row.type == Parameter::Type::choice) return text;
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stop != end) return text;
  return number;
}

std::string type_text(const Parameter& row) {
  if (!row.choices.empty()) return fmt::format("{}", fmt::join(row.choices, "|"));
  return fmt::format("{}..{}", row.min, row.max);
}

std::string default_text(const Parameter& row) {
  if (row.optional) return {};
  return std::visit([](const auto& value) { return fmt::format("{}", value); }, row.fallback);
}

}  // namespace

std::string kebab_case(std::string_view name) {
  std::string text(name);
  std::ranges::replace(text, '_', '-');
  return text;
}

void ParameterOptions::add_to(CLI::App& command) {
  CLI::Option* preset = command.add_option("--preset", preset_, "Named set of parameters to start from");
  std::vector<std::string> names;
  for (const Preset& row : meshing_presets()) names.emplace_back(row.name);
  preset->check(CLI::IsMember(names));
  command
      .add_option("--params", file_,
                  "JSON file with parameters to start from, by their names in snake_case; - reads stdin")
      ->excludes(preset);
  for (const Parameter& row : meshing_parameters()) add_row(command, row);
}

void ParameterOptions::add_row(CLI::App& command, const Parameter& row) {
  const std::string flag = "--" + kebab_case(row.name), name(row.name), meaning(row.meaning);
  CLI::Option* option = nullptr;
  if (row.type == Parameter::Type::boolean) {
    option = command.add_flag_callback(
        flag, [this, name] { values_.emplace_back(name, true); }, meaning);
    command
        .add_flag_callback(
            "--no" + flag.substr(1), [this, name] { values_.emplace_back(name, false); },
            "The opposite of " + flag)
        ->excludes(option)
        ->group("Meshing");
  } else {
    option = command.add_option_function<std::string>(
        flag,
        [this, name, &row](const std::string& text) { values_.emplace_back(name, parse_value(row, text)); },
        meaning);
    option->type_name(type_text(row));
    option->default_str(default_text(row));
  }
  option->group("Meshing");
}

MeshingOptions ParameterOptions::resolve(Cells cells) const {
  MeshingOptions options;
  if (!preset_.empty()) options = preset_options(preset_);
  if (!file_.empty()) options = read_meshing_options(read_bytes(file_));
  set_parameters(options, values_, cells);
  return options;
}

}  // namespace isochor
