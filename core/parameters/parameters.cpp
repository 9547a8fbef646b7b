#include "core/parameters/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

std::optional<double> as_number(const ParameterValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return static_cast<double>(*integer);
  if (const auto* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

std::string join(std::span<const std::string_view> choices) {
  return fmt::format("{}", fmt::join(choices, ", "));
}

std::optional<std::string> fault_of_number(const Parameter& row, const ParameterValue& value) {
  const std::optional<double> number = as_number(value);
  const bool whole = row.type == Parameter::Type::integer;
  if (!number || !std::isfinite(*number) || (whole && *number != std::floor(*number)))
    return whole ? "must be a whole number" : "must be a number";
  if (*number < row.min || *number > row.max)
    return fmt::format("must be from {} to {}, not {}", row.min, row.max, *number);
  if (!row.choices.empty() && std::ranges::find(row.choices, fmt::format("{}", *number)) == row.choices.end())
    return fmt::format("must be one of {}, not {}", join(row.choices), *number);
  return std::nullopt;
}

std::optional<std::string> fault_of_choice(const Parameter& row, const ParameterValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text && std::ranges::find(row.choices, *text) != row.choices.end()) return std::nullopt;
  return fmt::format("must be one of {}", join(row.choices));
}

/// The type that the row's setter expects.
ParameterValue coerced(const Parameter& row, const ParameterValue& value) {
  if (row.type == Parameter::Type::integer) return static_cast<std::int64_t>(*as_number(value));
  if (row.type == Parameter::Type::number) return *as_number(value);
  return value;
}

std::string pointer_to(std::string_view name) {
  return fmt::format("/{}", name);
}

[[noreturn]] void refuse(std::vector<ErrorDetail> faults) {
  std::string what = "invalid parameters:";
  for (const ErrorDetail& fault : faults)
    what += fmt::format(" {} {};", fault.pointer.substr(1), fault.detail);
  what.pop_back();
  throw Error(ErrorCode::invalid_argument, what, "`isochor mesh --help` lists every parameter with its range",
              std::move(faults));
}

/// Faults between fields; each alone is in its range.
void add_relation_faults(const MeshingOptions& options, std::vector<ErrorDetail>& faults) {
  const int most_cells = options.voxels / 2;
  if (options.lattice.cells > most_cells)
    faults.push_back({"/cells",
                      fmt::format("must be at most voxels/2 = {}, not {}: lower cells, or raise voxels to {}",
                                  most_cells, options.lattice.cells, 2 * options.lattice.cells),
                      2, most_cells});
  const PseudoVolumeOptions& thresholds = options.pseudo_volume;
  if (!thresholds.p_in && !thresholds.p_subs && thresholds.p_subs_voxels < thresholds.p_in_voxels)
    faults.push_back({"/p_subs_voxels",
                      fmt::format("must be at least p_in_voxels = {}, not {}", thresholds.p_in_voxels,
                                  thresholds.p_subs_voxels),
                      thresholds.p_in_voxels, find_parameter("p_subs_voxels")->max});
  if (thresholds.p_in && thresholds.p_subs && *thresholds.p_subs > *thresholds.p_in)
    faults.push_back({"/p_subs",
                      fmt::format("must be at most p_in = {}, not {}", *thresholds.p_in, *thresholds.p_subs),
                      0.0, *thresholds.p_in});
}

void add_range_faults(const MeshingOptions& options, std::vector<ErrorDetail>& faults) {
  for (const Parameter& row : meshing_parameters())
    if (const auto value = row.get(options))
      if (auto fault = check_value(row, *value)) faults.push_back(std::move(*fault));
}

std::string text_of(const ParameterValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

}  // namespace

const Parameter* find_parameter(std::string_view name) {
  const auto rows = meshing_parameters();
  const auto found = std::ranges::find(rows, name, &Parameter::name);
  return found == rows.end() ? nullptr : &*found;
}

std::optional<ErrorDetail> check_value(const Parameter& parameter, const ParameterValue& value) {
  std::optional<std::string> fault;
  const bool numeric =
      parameter.type == Parameter::Type::integer || parameter.type == Parameter::Type::number;
  if (numeric)
    fault = fault_of_number(parameter, value);
  else if (parameter.type == Parameter::Type::choice)
    fault = fault_of_choice(parameter, value);
  else if (!std::holds_alternative<bool>(value))
    fault = "must be true or false";
  if (!fault) return std::nullopt;
  ErrorDetail detail{pointer_to(parameter.name), std::move(*fault), {}, {}};
  if (numeric) detail.min = parameter.min, detail.max = parameter.max;
  return detail;
}

void set_parameters(MeshingOptions& options, std::span<const NamedValue> values, Cells cells) {
  std::vector<ErrorDetail> faults;
  for (const auto& [name, value] : values)
    if (!find_parameter(name)) faults.push_back({pointer_to(name), "is not a parameter", {}, {}});
  MeshingOptions changed = options;
  for (const Parameter& row : meshing_parameters())
    for (const auto& [name, value] : values) {
      if (name != row.name) continue;
      if (auto fault = check_value(row, value))
        faults.push_back(std::move(*fault));
      else
        row.set(changed, coerced(row, value));
    }
  const bool among_them =
      std::ranges::any_of(values, [](const NamedValue& value) { return value.first == "cells"; });
  if (cells == Cells::sought && !among_them)
    changed.lattice.cells = std::min(changed.lattice.cells, changed.voxels / 2);
  add_relation_faults(changed, faults);
  if (!faults.empty()) refuse(std::move(faults));
  options = changed;
}

void set_parameter(MeshingOptions& options, std::string_view name, const ParameterValue& value) {
  const NamedValue named{std::string(name), value};
  set_parameters(options, {&named, 1});
}

void validate(const MeshingOptions& options) {
  std::vector<ErrorDetail> faults;
  add_range_faults(options, faults);
  add_relation_faults(options, faults);
  if (!faults.empty()) refuse(std::move(faults));
}

std::string describe(const MeshingOptions& options) {
  std::string text;
  for (const Parameter& row : meshing_parameters())
    if (const auto value = row.get(options))
      text += fmt::format("{}{}={}", text.empty() ? "" : " ", row.name, text_of(*value));
  return text;
}

}  // namespace isochor
