#include "server/messages/json_text.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>

namespace isochor {
namespace {

static_assert(std::endian::native == std::endian::little, "typed arrays are sent as they lie in memory");

template <class T>
void append_number(std::string& out, T value) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  out.append(buffer.data(), end);
}

/// Length of the valid UTF-8 sequence at the start of text, 0 when there is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xC2 ? 0
                             : lead < 0xE0 ? 2
                             : lead < 0xF0 ? 3
                             : lead < 0xF5 ? 4
                                           : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (lead == 0xE0 && byte(1) < 0xA0) return 0;   // overlong
  if (lead == 0xED && byte(1) >= 0xA0) return 0;  // surrogate
  if (lead == 0xF0 && byte(1) < 0x90) return 0;   // overlong
  if (lead == 0xF4 && byte(1) >= 0x90) return 0;  // above U+10FFFF
  return length;
}

void append_control(std::string& out, unsigned char c) {
  constexpr std::string_view hex = "0123456789abcdef";
  out += "\\u00";
  out += hex[c >> 4];
  out += hex[c & 15];
}

/// Two characters for each 12 bits: half the look-ups of the usual table of 64.
const std::array<std::array<char, 2>, 4096>& base64_pairs() {
  static const auto table = [] {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::array<char, 2>, 4096> pairs;
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {digits[i >> 6], digits[i & 63]};
    return pairs;
  }();
  return table;
}

}  // namespace

void append_json(std::string& out, double value) {
  if (std::isfinite(value))
    append_number(out, value);
  else
    out += "null";
}

void append_json(std::string& out, float value) {
  if (std::isfinite(value))
    append_number(out, value);
  else
    out += "null";
}

void append_json(std::string& out, std::int64_t value) {
  append_number(out, value);
}

void append_json(std::string& out, std::string_view text) {
  out += '"';
  while (!text.empty()) {
    const auto c = static_cast<unsigned char>(text.front());
    std::size_t length = utf8_length(text);
    if (length == 0) {
      out += "\xEF\xBF\xBD";
      length = 1;
    } else if (c < 0x20) {
      append_control(out, c);
    } else {
      if (c == '"' || c == '\\') out += '\\';
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  out += '"';
}

void append_json(std::string& out, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) {
    out += axis == 0 ? '[' : ',';
    append_json(out, value[axis]);
  }
  out += ']';
}

void append_base64(std::string& out, std::span<const std::byte> bytes) {
  const auto& pairs = base64_pairs();
  const std::size_t start = out.size();
  const std::size_t whole = bytes.size() / 3, rest = bytes.size() % 3;
  out.resize(start + 4 * (whole + (rest != 0 ? 1 : 0)), '=');
  char* to = out.data() + start;
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto put = [&](unsigned triple, int characters) {
    const auto &high = pairs[triple >> 12], &low = pairs[triple & 4095];
    const std::array<char, 4> four{high[0], high[1], low[0], low[1]};
    for (int i = 0; i < characters; ++i) to[i] = four[static_cast<std::size_t>(i)];
    to += 4;
  };
  for (std::size_t i = 0; i < whole; ++i, from += 3)
    put(unsigned{from[0]} << 16 | unsigned{from[1]} << 8 | unsigned{from[2]}, 4);
  if (rest == 1) put(unsigned{from[0]} << 16, 2);
  if (rest == 2) put(unsigned{from[0]} << 16 | unsigned{from[1]} << 8, 3);
}

void begin_typed_array(std::string& out, std::string_view dtype, std::size_t count, int columns) {
  out += R"({"dtype":")";
  out += dtype;
  out += R"(","shape":[)";
  append_json(out,
              static_cast<std::int64_t>(columns > 0 ? count / static_cast<std::size_t>(columns) : count));
  if (columns > 0) {
    out += ',';
    append_json(out, std::int64_t{columns});
  }
  out += R"(],"data":")";
}

void end_typed_array(std::string& out) {
  out += R"("})";
}

}  // namespace isochor
