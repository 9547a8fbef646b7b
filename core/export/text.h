#pragma once
#include <array>
#include <charconv>
#include <concepts>
#include <string>
#include <string_view>

#include "core/common/types.h"

namespace isochor {

/// Text of a file under construction. Numbers are the shortest that read back the same bits, whatever the
/// locale, so volumes survive and the same model gives the same bytes.
class Text {
 public:
  Text& operator<<(std::string_view text) {
    content_ += text;
    return *this;
  }
  Text& operator<<(const char* text) { return *this << std::string_view(text); }
  Text& operator<<(char character) {
    content_ += character;
    return *this;
  }
  template <class Number>
  requires(std::integral<Number> || std::floating_point<Number>) Text& operator<<(Number number) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    content_.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
    return *this;
  }
  Text& operator<<(const Vec3& v) { return *this << v.x() << ' ' << v.y() << ' ' << v.z(); }
  /// Indices separated by spaces.
  template <std::size_t Count>
  Text& operator<<(const std::array<std::int32_t, Count>& indices) {
    return list(indices, ' ', 0);
  }
  template <std::size_t Count>
  Text& list(const std::array<std::int32_t, Count>& indices, char separator, int base) {
    for (std::size_t i = 0; i < Count; ++i) {
      if (i > 0) content_ += separator;
      *this << indices[i] + base;
    }
    return *this;
  }

  void reserve(std::size_t bytes) { content_.reserve(bytes); }
  std::string take() { return std::move(content_); }

 private:
  std::string content_;
};

/// For a value between quotes, in JSON and elsewhere: what would need an escape becomes a question mark.
inline std::string without_escapes(std::string text) {
  for (char& c : text)
    if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
      c = '?';
  return text;
}

}  // namespace isochor
