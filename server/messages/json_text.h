#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/common/types.h"

namespace isochor {

/// Text of JSON written straight into a string, for what is too large or too frequent for a tree.
/// Numbers are the shortest that read back the same; a value that is not finite becomes null.
void append_json(std::string& out, double value);
void append_json(std::string& out, float value);
void append_json(std::string& out, std::int64_t value);
void append_json(std::string& out, std::string_view text);  ///< quoted; invalid UTF-8 becomes U+FFFD
void append_json(std::string& out, const Vec3& value);      ///< [x,y,z]

void append_base64(std::string& out, std::span<const std::byte> bytes);

/// The one form of bulk numbers: {"dtype":"float32","shape":[rows,columns],"data":"<base64, little-endian>"};
/// columns 0 makes it one-dimensional.
template <class T>
void append_typed_array(std::string& out, std::span<const T> values, int columns);
/// What stands before and after the base64 of so many items.
void begin_typed_array(std::string& out, std::string_view dtype, std::size_t count, int columns);
void end_typed_array(std::string& out);

template <class T>
constexpr std::string_view dtype_name() {
  if constexpr (std::is_same_v<T, float>) return "float32";
  if constexpr (std::is_same_v<T, double>) return "float64";
  if constexpr (std::is_same_v<T, std::int32_t>) return "int32";
  if constexpr (std::is_same_v<T, std::uint32_t>) return "uint32";
  if constexpr (std::is_same_v<T, std::uint8_t>) return "uint8";
}

template <class T>
void append_typed_array(std::string& out, std::span<const T> values, int columns) {
  begin_typed_array(out, dtype_name<T>(), values.size(), columns);
  append_base64(out, std::as_bytes(values));
  end_typed_array(out);
}

/// {"key":value,…} with as many calls as there are members.
class ObjectWriter {
 public:
  explicit ObjectWriter(std::string& out) : out_(out) { out_ += '{'; }
  ~ObjectWriter() { out_ += '}'; }
  ObjectWriter(const ObjectWriter&) = delete;
  ObjectWriter& operator=(const ObjectWriter&) = delete;

  std::string& key(std::string_view name) {
    if (!std::exchange(first_, false)) out_ += ',';
    out_ += '"';
    out_ += name;
    out_ += "\":";
    return out_;
  }
  template <class T>
  void member(std::string_view name, const T& value) {
    append_json(key(name), value);
  }
  void member(std::string_view name, bool value) { key(name) += value ? "true" : "false"; }
  void member(std::string_view name, int value) { append_json(key(name), std::int64_t{value}); }
  void member(std::string_view name, const std::string& value) {
    append_json(key(name), std::string_view(value));
  }
  void member(std::string_view name, const char* value) { append_json(key(name), std::string_view(value)); }

 private:
  std::string& out_;
  bool first_ = true;
};

/// [item,…]
template <class Range, class Write>
void append_list(std::string& out, const Range& items, const Write& write) {
  out += '[';
  bool first = true;
  for (const auto& item : items) {
    if (!first) out += ',';
    first = false;
    write(item);
  }
  out += ']';
}

}  // namespace isochor
