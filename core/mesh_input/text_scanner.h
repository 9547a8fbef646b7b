#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace isochor {

/// Coordinates beyond this are refused: their squares and products would leave the range that the geometry
/// and the float exports can hold.
inline constexpr double largest_coordinate = 1e30;

/// The whole token as a number (decimal, with an optional sign), or false.
bool parse_number(std::string_view token, double& value);
bool parse_integer(std::string_view token, std::int64_t& value);

/// Walks text bytes line by line and token by token, and names the line in every complaint. Lines end with a
/// line feed or, where the text has none, with carriage returns; a UTF-8 byte order mark is passed over.
class TextScanner {
 public:
  explicit TextScanner(std::span<const char> bytes);

  bool next_line();
  /// Next word of the current line, empty at its end.
  std::string_view token();
  /// Next word of the text, across lines; empty at the end.
  std::string_view word();
  /// Cuts a comment off the current line.
  void strip_comment(char mark = '#');

  std::int64_t line() const { return line_number_; }
  std::size_t bytes_left() const { return line_.size() + rest_.size(); }
  /// The bytes after the current line, and where they begin.
  std::string_view rest() const { return rest_; }
  std::size_t offset() const { return static_cast<std::size_t>(rest_.data() - begin_); }

  /// The token as a finite coordinate; complains otherwise.
  void check_coordinate(std::string_view token) const;
  std::int64_t integer(std::string_view token) const;
  [[noreturn]] void fail(const std::string& what, const std::string& hint = {}) const;

 private:
  const char* begin_;
  std::string_view rest_, line_;
  std::int64_t line_number_ = 0;
  char line_end_;
};

}  // namespace isochor
