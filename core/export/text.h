#pragma once
#include <array>
#include <charconv>
#include <concepts>
#include <string>
#include <string_view>
#include <utility>

#include "core/common/text_sink.h"
#include "core/common/types.h"

namespace isochor {

/// Text of a file under construction. Numbers are the shortest that read back the same bits, whatever the
/// locale, so volumes survive and the same model gives the same bytes. It is kept for take(), or goes to a
/// sink a piece at a time, the last one by pass_on().
class Text {
 public:
  Text() = default;
  explicit Text(TextSink sink) : sink_(std::move(sink)), most_kept_(text_piece_bytes) {}

  Text& operator<<(std::string_view text) {
    content_ += text;
    return grown();
  }
  Text& operator<<(const char* text) { return *this << std::string_view(text); }
  Text& operator<<(char character) {
    content_ += character;
    return grown();
  }
  template <class Number>
  requires(std::integral<Number> || std::floating_point<Number>) Text& operator<<(Number number) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    content_.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
    return grown();
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

  std::string take() { return std::move(content_); }
  void pass_on() {
    if (content_.empty()) return;
    sink_(content_);
    content_.clear();
  }

 private:
  Text& grown() {
    if (content_.size() >= most_kept_) pass_on();
    return *this;
  }

  std::string content_;
  TextSink sink_;
  std::size_t most_kept_ = std::string::npos;
};

/// For a value between quotes, in JSON and elsewhere: what would need an escape becomes a question mark.
inline std::string without_escapes(std::string text) {
  for (char& c : text)
    if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e)
      c = '?';
  return text;
}

}  // namespace isochor
