#include "core/scene/json_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace isochor {
namespace {

constexpr int max_depth = 32;

/// Brackets outside strings, counted without building anything.
int nesting_depth(std::string_view text) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

std::string escaped(std::string_view name) {
  std::string text;
  for (const char c : name) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

}  // namespace

Json parse_json(std::string_view text, std::string_view what) {
  if (text.size() > max_json_bytes)
    throw Error(ErrorCode::cannot_read,
                fmt::format("{} is {} bytes long; at most {} are read", what, text.size(), max_json_bytes),
                "keep large data in mesh files and name them");
  if (nesting_depth(text) > max_depth)
    throw Error(ErrorCode::cannot_read, fmt::format("{} nests deeper than {} levels", what, max_depth));
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw Error(ErrorCode::cannot_read, fmt::format("byte {} of {} is not valid JSON", error.byte, what),
                "check for a missing comma, bracket or quote there");
  } catch (const Json::out_of_range&) {
    throw Error(ErrorCode::cannot_read, fmt::format("{} holds a number beyond the range of a double", what));
  }
}

JsonFields::JsonFields(const Json& object, std::string pointer, std::vector<ErrorDetail>& faults)
    : object_(object), pointer_(std::move(pointer)), faults_(faults) {
  if (!object_.is_object()) faults_.push_back({pointer_, "must be an object", {}, {}});
}

void JsonFields::note_unknown() {
  if (!object_.is_object()) return;
  for (const auto& [name, value] : object_.items()) {
    if (enough(faults_)) return;
    if (std::ranges::find(known_, name) == known_.end())
      faults_.push_back(
          {pointer(name), fmt::format("is not known here; known are {}", fmt::join(known_, ", ")), {}, {}});
  }
}

const Json* JsonFields::find(std::string_view name) {
  if (std::ranges::find(known_, name) == known_.end()) known_.emplace_back(name);
  if (!object_.is_object()) return nullptr;
  const auto found = object_.find(name);
  return found == object_.end() ? nullptr : &*found;
}

std::string JsonFields::pointer(std::string_view name) const {
  return pointer_ + "/" + escaped(name);
}

void JsonFields::fault(std::string_view name, std::string detail) {
  faults_.push_back({pointer(name), std::move(detail), {}, {}});
}

bool read_number(const Json& value, const std::string& pointer, Range range, double& target,
                 std::vector<ErrorDetail>& faults) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (number >= range.min && number <= range.max) {
    target = number;
    return true;
  }
  const std::string limits = fmt::format("must be a number from {} to {}", range.min, range.max);
  faults.push_back({pointer, limits, range.min, range.max});
  return false;
}

void JsonFields::read(std::string_view name, double& target, Range range) {
  if (const Json* value = find(name)) read_number(*value, pointer(name), range, target, faults_);
}

void JsonFields::read(std::string_view name, int& target, Range range) {
  double number = target;
  const Json* value = find(name);
  if (!value || !read_number(*value, pointer(name), range, number, faults_)) return;
  if (number != std::floor(number)) return fault(name, "must be a whole number");
  target = static_cast<int>(number);
}

void JsonFields::read(std::string_view name, std::uint64_t& target, Range range) {
  double number = 0.0;
  const Json* value = find(name);
  if (!value || !read_number(*value, pointer(name), range, number, faults_)) return;
  if (number != std::floor(number)) return fault(name, "must be a whole number");
  target = static_cast<std::uint64_t>(number);
}

void JsonFields::read(std::string_view name, bool& target) {
  const Json* value = find(name);
  if (!value) return;
  if (!value->is_boolean()) return fault(name, "must be true or false");
  target = value->get<bool>();
}

void JsonFields::read(std::string_view name, std::string& target) {
  const Json* value = find(name);
  if (!value) return;
  if (!value->is_string()) return fault(name, "must be a string");
  const auto& text = value->get_ref<const std::string&>();
  if (text.size() > max_name_bytes)
    return fault(name, fmt::format("is {} bytes long; at most {} are taken", text.size(), max_name_bytes));
  target = text;
}

void JsonFields::read(std::string_view name, Vec3& target, Range range) {
  const Json* value = find(name);
  if (!value) return;
  if (!value->is_array() || value->size() != 3) return fault(name, "must be three numbers");
  Vec3 read;
  bool good = true;
  for (int i = 0; i < 3; ++i)
    good &= read_number((*value)[i], fmt::format("{}/{}", pointer(name), i), range, read[i], faults_);
  if (good) target = read;
}

void JsonFields::read(std::string_view name, Vec3i& target, Range range) {
  Vec3 numbers = target.cast<double>();
  read(name, numbers, range);
  if (numbers != numbers.array().floor().matrix()) return fault(name, "must be three whole numbers");
  target = numbers.cast<int>();
}

void JsonFields::read(std::string_view name, Eigen::Matrix3d& target, Range range) {
  const Json* value = find(name);
  if (!value) return;
  if (!value->is_array() || value->size() != 3) return fault(name, "must be three rows of three numbers");
  Eigen::Matrix3d read;
  for (int i = 0; i < 3; ++i) {
    const Json& row = (*value)[i];
    if (!row.is_array() || row.size() != 3) return fault(name, "must be three rows of three numbers");
    for (int j = 0; j < 3; ++j) {
      if (!read_number(row[j], fmt::format("{}/{}/{}", pointer(name), i, j), range, read(i, j), faults_))
        return;
    }
  }
  target = read;
}

void JsonFields::read(std::string_view name, Eigen::Quaterniond& target) {
  const Json* value = find(name);
  if (!value) return;
  if (!value->is_array() || value->size() != 4) return fault(name, "must be four numbers x, y, z, w");
  Eigen::Vector4d read;
  for (int i = 0; i < 4; ++i) {
    if (!read_number((*value)[i], fmt::format("{}/{}", pointer(name), i), {-1e6, 1e6}, read[i], faults_))
      return;
  }
  if (read.norm() < 1e-6) return fault(name, "must not be zero");
  target = Eigen::Quaterniond(read).normalized();
}

int JsonFields::choice(std::string_view name, std::span<const std::string_view> choices) {
  const Json* value = find(name);
  if (!value) return -1;
  const std::string text = value->is_string() ? value->get<std::string>() : std::string();
  const auto found = std::ranges::find(choices, text);
  if (found != choices.end()) return static_cast<int>(found - choices.begin());
  fault(name, fmt::format("must be one of {}", fmt::join(choices, ", ")));
  return -1;
}

void throw_faults(std::string_view what, std::vector<ErrorDetail> faults) {
  if (faults.empty()) return;
  std::string text =
      fmt::format("{} faulty field{} in {}:", faults.size(), faults.size() == 1 ? "" : "s", what);
  for (const ErrorDetail& fault : faults)
    text += fmt::format(" {} {};", fault.pointer.empty() ? "/" : fault.pointer, fault.detail);
  text.pop_back();
  throw Error(ErrorCode::invalid_argument, text, "correct or remove each field named", std::move(faults));
}

}  // namespace isochor
