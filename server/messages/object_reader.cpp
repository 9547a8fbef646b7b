#include "server/messages/object_reader.h"

#include <algorithm>

namespace isochor {

ObjectReader::ObjectReader(const Json& json, std::string pointer)
    : json_(json), pointer_(std::move(pointer)) {
  if (!json_.is_object())
    throw Error(ErrorCode::invalid_argument, "an object is expected", {},
                {{pointer_, "is not an object", {}, {}}});
}

void ObjectReader::fault(const std::string& name, std::string detail, std::optional<double> min,
                         std::optional<double> max) {
  faults_.push_back({pointer_ + "/" + name, std::move(detail), min, max});
}

void ObjectReader::take_faults(std::vector<ErrorDetail> faults) {
  for (ErrorDetail& detail : faults) faults_.push_back(std::move(detail));
}

const Json* ObjectReader::member(const std::string& name) {
  known_.push_back(name);
  const auto found = json_.find(name);
  return found == json_.end() || found->is_null() ? nullptr : &*found;
}

std::optional<bool> ObjectReader::boolean(const std::string& name) {
  const Json* value = member(name);
  if (!value) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  fault(name, "is not true or false");
  return std::nullopt;
}

std::optional<double> ObjectReader::number(const std::string& name, double min, double max) {
  const Json* value = member(name);
  if (!value) return std::nullopt;
  if (value->is_number()) {
    const double number = value->get<double>();
    if (number >= min && number <= max) return number;
  }
  fault(name, value->is_number() ? "is out of range" : "is not a number", min, max);
  return std::nullopt;
}

/// Range-checked as a double before it becomes an integer.
std::optional<std::int64_t> ObjectReader::integer(const std::string& name, std::int64_t min,
                                                  std::int64_t max) {
  const auto value = number(name, static_cast<double>(min), static_cast<double>(max));
  if (!value) return std::nullopt;
  if (*value == std::floor(*value)) return static_cast<std::int64_t>(*value);
  fault(name, "is not an integer", static_cast<double>(min), static_cast<double>(max));
  return std::nullopt;
}

std::optional<std::string> ObjectReader::text(const std::string& name) {
  const Json* value = member(name);
  if (!value) return std::nullopt;
  if (value->is_string()) return value->get<std::string>();
  fault(name, "is not a string");
  return std::nullopt;
}

std::optional<std::vector<double>> ObjectReader::numbers(const std::string& name, std::size_t count) {
  const Json* value = member(name);
  if (!value) return std::nullopt;
  const auto finite = [](const Json& item) { return item.is_number() && std::isfinite(item.get<double>()); };
  if (value->is_array() && value->size() == count && std::all_of(value->begin(), value->end(), finite))
    return value->get<std::vector<double>>();
  fault(name, "is not a list of " + std::to_string(count) + " numbers");
  return std::nullopt;
}

std::optional<Vec3> ObjectReader::vector(const std::string& name) {
  const auto values = numbers(name, 3);
  if (!values) return std::nullopt;
  return Vec3(values->data());
}

std::optional<std::size_t> ObjectReader::choice(const std::string& name,
                                                const std::vector<std::string_view>& choices) {
  const auto value = text(name);
  if (!value) return std::nullopt;
  const auto found = std::find(choices.begin(), choices.end(), *value);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  std::string names;
  for (const std::string_view choice : choices) names += (names.empty() ? "" : ", ") + std::string(choice);
  fault(name, "is not one of " + names);
  return std::nullopt;
}

void ObjectReader::finish(std::string_view what) {
  for (const auto& [name, value] : json_.items())
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) fault(name, "is not known here");
  if (faults_.empty()) return;
  throw Error(ErrorCode::invalid_argument,
              std::string(what) + ": " + faults_.front().pointer + " " + faults_.front().detail,
              "correct the fields listed under errors", faults_);
}

}  // namespace isochor
