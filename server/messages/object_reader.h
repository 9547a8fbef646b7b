#pragma once
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/common/error.h"
#include "core/common/types.h"
#include "server/messages/json.h"

namespace isochor {

/// Reads the members of one JSON object and remembers what was wrong: faulty values, missing ones, and names
/// that nobody asked for. finish() throws all of it at once.
class ObjectReader {
 public:
  explicit ObjectReader(const Json& json, std::string pointer = {});

  bool has(const std::string& name) const { return json_.contains(name); }
  std::optional<bool> boolean(const std::string& name);
  std::optional<double> number(const std::string& name, double min, double max);
  std::optional<std::int64_t> integer(const std::string& name, std::int64_t min, std::int64_t max);
  std::optional<std::string> text(const std::string& name);
  std::optional<Vec3> vector(const std::string& name);
  std::optional<std::vector<double>> numbers(const std::string& name, std::size_t count);
  /// The index of the value among the choices.
  std::optional<std::size_t> choice(const std::string& name, const std::vector<std::string_view>& choices);
  /// A member that is read elsewhere; null when absent.
  const Json* member(const std::string& name);

  /// For members that must be there.
  template <class T>
  T required(const std::string& name, const std::optional<T>& value, T fallback = T{}) {
    if (!value && !json_.contains(name)) fault(name, "is missing");
    return value.value_or(fallback);
  }
  void fault(const std::string& name, std::string detail, std::optional<double> min = {},
             std::optional<double> max = {});
  void take_faults(std::vector<ErrorDetail> faults);
  const std::string& pointer() const { return pointer_; }

  void finish(std::string_view what);  ///< throws invalid_argument

 private:
  const Json& json_;
  std::string pointer_;
  std::vector<std::string> known_;
  std::vector<ErrorDetail> faults_;
};

}  // namespace isochor
