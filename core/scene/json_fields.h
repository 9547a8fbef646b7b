#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/common/error.h"
#include "core/common/types.h"

namespace isochor {

using Json = nlohmann::json;

struct Range {
  double min, max;
};

constexpr std::size_t max_json_bytes = 16 << 20;
constexpr std::size_t max_name_bytes = 255, max_path_bytes = 4096;

/// Parses text of bounded size and depth, before a tree of it is built. Throws cannot_read with the byte.
Json parse_json(std::string_view text, std::string_view what);

/// Whether as many faults are noted as anybody reads: what repeats, lists and unknown fields, ends then.
inline bool enough(const std::vector<ErrorDetail>& faults) {
  return faults.size() >= 100;
}

/// Reads the fields of one JSON object into native types. A fault never throws: it is noted by its pointer,
/// the target keeps its value, and reading goes on, so that all faults are told at once.
class JsonFields {
 public:
  JsonFields(const Json& object, std::string pointer, std::vector<ErrorDetail>& faults);
  JsonFields(const JsonFields&) = delete;
  JsonFields& operator=(const JsonFields&) = delete;

  /// The field, now known; nullptr when absent.
  const Json* find(std::string_view name);
  std::string pointer(std::string_view name) const;
  void fault(std::string_view name, std::string detail);

  void read(std::string_view name, double& target, Range range);
  void read(std::string_view name, int& target, Range range);
  void read(std::string_view name, std::uint64_t& target, Range range);
  void read(std::string_view name, bool& target);
  void read(std::string_view name, std::string& target);  ///< of at most max_name_bytes
  void read(std::string_view name, Vec3& target, Range range);
  void read(std::string_view name, Vec3i& target, Range range);
  void read(std::string_view name, Eigen::Matrix3d& target, Range range);  ///< three rows
  void read(std::string_view name, Eigen::Quaterniond& target);            ///< x, y, z, w; normalised

  /// Index of the string among the choices.
  template <class Enum>
  void read_choice(std::string_view name, Enum& target, std::span<const std::string_view> choices) {
    const int index = choice(name, choices);
    if (index >= 0) target = static_cast<Enum>(index);
  }

  /// Notes every field that nobody asked for.
  void note_unknown();

  std::vector<ErrorDetail>& faults() const { return faults_; }

 private:
  int choice(std::string_view name, std::span<const std::string_view> choices);

  const Json& object_;
  std::string pointer_;
  std::vector<ErrorDetail>& faults_;
  std::vector<std::string> known_;
};

/// What read(fields) makes of one object; then every field that it did not ask for is noted. Not left to a
/// destructor, because noting may run out of memory.
template <class Read>
auto read_object(const Json& object, std::string pointer, std::vector<ErrorDetail>& faults, Read&& read) {
  JsonFields fields(object, std::move(pointer), faults);
  if constexpr (std::is_void_v<decltype(read(fields))>) {
    read(fields);
    fields.note_unknown();
  } else {
    auto result = read(fields);
    fields.note_unknown();
    return result;
  }
}

/// A number within the range, or a fault at the pointer.
bool read_number(const Json& value, const std::string& pointer, Range range, double& target,
                 std::vector<ErrorDetail>& faults);

/// Throws invalid_argument that lists all faults; returns when there are none.
void throw_faults(std::string_view what, std::vector<ErrorDetail> faults);

}  // namespace isochor
