#include "tests/support/json_schema.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isochor::test {
namespace {

using nlohmann::json;

bool has_type(const std::string& type, const json& value) {
  if (type == "integer")
    return value.is_number_integer() || (value.is_number() && value == std::floor(value.get<double>()));
  if (type == "number") return value.is_number();
  return type == value.type_name();
}

constexpr std::array annotations{"description", "title", "default", "format", "contentEncoding", "then"};

}  // namespace

std::optional<std::string> JsonSchema::fault(const json& schema, const json& value,
                                             const std::string& at) const {
  if (schema.is_boolean())
    return schema.get<bool>() ? std::nullopt : std::optional(at + ": nothing belongs here");
  for (const auto& [keyword, argument] : schema.items())
    if (auto found = keyword_fault(keyword, argument, schema, value, at)) return found;
  return std::nullopt;
}

std::optional<std::string> JsonSchema::keyword_fault(const std::string& keyword, const json& argument,
                                                     const json& schema, const json& value,
                                                     const std::string& at) const {
  const auto failed = [&](bool fails) {
    return fails ? std::optional(at + ": " + keyword + " " + argument.dump() + " against " +
                                 value.dump().substr(0, 200))
                 : std::nullopt;
  };
  const auto none = std::optional<std::string>();
  if (keyword == "$ref")
    return fault(document_.at(json::json_pointer(argument.get<std::string>().substr(1))), value, at);
  if (keyword == "type") {
    const json types = argument.is_array() ? argument : json::array({argument});
    return failed(
        std::none_of(types.begin(), types.end(), [&](const json& type) { return has_type(type, value); }));
  }
  if (keyword == "enum") return failed(std::find(argument.begin(), argument.end(), value) == argument.end());
  if (keyword == "const") return failed(argument != value);
  if (keyword == "minimum") return failed(value.is_number() && value < argument);
  if (keyword == "maximum") return failed(value.is_number() && value > argument);
  if (keyword == "minItems") return failed(value.is_array() && value.size() < argument);
  if (keyword == "maxItems") return failed(value.is_array() && value.size() > argument);
  if (keyword == "required") {
    return failed(value.is_object() && !std::all_of(argument.begin(), argument.end(), [&](const json& name) {
                    return value.contains(name.get<std::string>());
                  }));
  }
  if (keyword == "properties" && value.is_object()) {
    for (const auto& [name, property] : argument.items())
      if (value.contains(name))
        if (auto found = fault(property, value[name], at + "/" + name)) return found;
    return none;
  }
  if (keyword == "additionalProperties" && value.is_object()) {
    for (const auto& [name, item] : value.items())
      if (!schema.contains("properties") || !schema["properties"].contains(name))
        if (auto found = fault(argument, item, at + "/" + name)) return found;
    return none;
  }
  if (keyword == "items" && value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i)
      if (auto found = fault(argument, value[i], at + "/" + std::to_string(i))) return found;
    return none;
  }
  const auto matching = [&] {
    return std::count_if(argument.begin(), argument.end(),
                         [&](const json& option) { return holds(option, value); });
  };
  if (keyword == "anyOf") return failed(matching() == 0);
  if (keyword == "oneOf") return failed(matching() != 1);
  if (keyword == "allOf") {
    for (const json& part : argument)
      if (auto found = fault(part, value, at)) return found;
    return none;
  }
  if (keyword == "if")
    return holds(argument, value) ? fault(schema.value("then", json(true)), value, at) : none;
  if (keyword == "properties" || keyword == "items" || keyword == "additionalProperties") return none;
  if (std::find(annotations.begin(), annotations.end(), keyword) != annotations.end()) return none;
  return at + ": the validator does not know " + keyword;
}

}  // namespace isochor::test
