#pragma once
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace isochor::test {

/// RFC 4648, written apart from the encoder.
inline std::string decode_base64(std::string_view text) {
  const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    const auto digit = digits.find(c);
    if (digit == std::string_view::npos) throw std::runtime_error("not base64");
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xFF);
  }
  return bytes;
}

/// Values of {"dtype","shape","data"}; the shape must fit the data.
template <class T>
std::vector<T> decode_typed_array(const nlohmann::json& json) {
  const std::string bytes = decode_base64(json.at("data").get<std::string>());
  std::size_t count = 1;
  for (const auto& extent : json.at("shape")) count *= extent.get<std::size_t>();
  if (bytes.size() != count * sizeof(T)) throw std::runtime_error("shape and data disagree");
  std::vector<T> values(count);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace isochor::test
