#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace isochor::test {

/// The part of JSON Schema 2020-12 that the API's description uses: what is wrong with a value, if anything.
/// A keyword that it does not know is an error of its own, so that no constraint is passed over.
class JsonSchema {
 public:
  /// document: where "#/…" references point into.
  explicit JsonSchema(nlohmann::json document) : document_(std::move(document)) {}

  std::optional<std::string> fault(const nlohmann::json& schema, const nlohmann::json& value,
                                   const std::string& at = "") const;
  const nlohmann::json& document() const { return document_; }

 private:
  std::optional<std::string> keyword_fault(const std::string& keyword, const nlohmann::json& argument,
                                           const nlohmann::json& schema, const nlohmann::json& value,
                                           const std::string& at) const;
  bool holds(const nlohmann::json& schema, const nlohmann::json& value) const {
    return !fault(schema, value);
  }

  nlohmann::json document_;
};

}  // namespace isochor::test
