#include "core/mesh_input/text_scanner.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>

#include "core/common/error.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Bytes of a file made fit to be shown.
std::string printable(std::string_view token) {
  std::string shown;
  for (char c : token.substr(0, 40)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown;
}

/// std::from_chars takes no plus; behind it no other sign may stand.
bool take_plus(std::string_view& token) {
  if (!token.starts_with('+')) return true;
  token.remove_prefix(1);
  return !token.starts_with('-');
}

}  // namespace

bool parse_number(std::string_view token, double& value) {
  if (!take_plus(token)) return false;
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  if (stop != end) return false;
  if (error == std::errc::result_out_of_range) {
    // Too large, or too small and then as good as zero: the exponent's sign tells.
    const std::size_t exponent = token.find_first_of("eE");
    const bool tiny = exponent == std::string_view::npos ? token.find_first_of("123456789") > token.find('.')
                                                         : token.substr(exponent + 1).starts_with('-');
    value = tiny ? 0.0 : HUGE_VAL;
    return true;
  }
  return error == std::errc{};
}

bool parse_integer(std::string_view token, std::int64_t& value) {
  if (!take_plus(token)) return false;
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, value);
  return error == std::errc{} && stop == end;
}

TextScanner::TextScanner(std::span<const char> bytes)
    : begin_(bytes.data()), rest_(bytes.data(), bytes.size()) {
  if (constexpr std::string_view byte_order_mark = "\xef\xbb\xbf"; rest_.starts_with(byte_order_mark))
    rest_.remove_prefix(byte_order_mark.size());
  line_end_ = rest_.find('\n') == std::string_view::npos ? '\r' : '\n';
}

bool TextScanner::next_line() {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find(line_end_), rest_.size());
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (++line_number_ % 4096 == 0) throw_if_scope_cancelled();
  return true;
}

std::string_view TextScanner::token() {
  std::size_t begin = 0;
  while (begin < line_.size() && is_space(line_[begin])) ++begin;
  std::size_t end = begin;
  while (end < line_.size() && !is_space(line_[end])) ++end;
  const std::string_view token = line_.substr(begin, end - begin);
  line_.remove_prefix(end);
  return token;
}

std::string_view TextScanner::word() {
  for (;;) {
    if (const std::string_view found = token(); !found.empty()) return found;
    if (!next_line()) return {};
  }
}

void TextScanner::strip_comment(char mark) {
  line_ = line_.substr(0, line_.find(mark));
}

void TextScanner::check_coordinate(std::string_view token) const {
  double value = 0.0;
  if (token.empty()) fail("a coordinate is missing", "the file may be truncated");
  if (!parse_number(token, value))
    fail(fmt::format("\"{}\" is not a number", printable(token)),
         token.find(',') == std::string_view::npos
             ? "export the file again"
             : "export the file with points, not commas, in its numbers");
  if (!std::isfinite(value)) fail("a coordinate is not finite", "repair or remove this vertex");
  if (std::abs(value) > largest_coordinate)
    fail(fmt::format("the coordinate {} is too large", printable(token)),
         fmt::format("scale the model so that coordinates stay below {:g}", largest_coordinate));
}

std::int64_t TextScanner::integer(std::string_view token) const {
  std::int64_t value = 0;
  if (token.empty()) fail("a whole number is missing", "the file may be truncated");
  if (!parse_integer(token, value)) fail(fmt::format("\"{}\" is not a whole number", printable(token)));
  return value;
}

void TextScanner::fail(const std::string& what, const std::string& hint) const {
  throw Error(ErrorCode::cannot_read, fmt::format("line {}: {}", line_number_, what), hint);
}

}  // namespace isochor
