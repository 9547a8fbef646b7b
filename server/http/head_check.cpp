#include "server/http/head_check.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace isochor {
namespace {

bool is_token_char(char c) {
  constexpr std::string_view extra = "!#$%&'*+-.^_`|~";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         extra.find(c) != std::string_view::npos;
}

Refusal malformed(std::string detail) {
  return {400, "malformed_request", std::move(detail),
          "send one HTTP/1.1 request a connection, lines ending in CRLF"};
}

/// Does not leave early, so that many characters are looked at at once: lines may be long.
bool holds_control(std::string_view line) {
  unsigned char found = 0;
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    found |= static_cast<unsigned char>(((byte < 0x20) & (byte != '\t')) | (byte == 0x7F));
  }
  return found != 0;
}

/// The next line without its CRLF; nullopt when it holds a bare CR, LF or another control character.
std::optional<std::string_view> take_line(std::string_view& rest) {
  const std::size_t end = rest.find("\r\n");
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end + 2);
  if (holds_control(line)) return std::nullopt;
  return line;
}

/// Splits an absolute target. An empty path is "/" (RFC 9110, 4.2.3).
void take_authority(Head& head) {
  constexpr std::string_view scheme = "http://";
  if (lower_case(std::string_view(head.target).substr(0, scheme.size())) != scheme) return;
  const std::size_t end = std::min(head.target.find_first_of("/?", scheme.size()), head.target.size());
  if (end == scheme.size()) return;
  head.authority = lower_case(std::string_view(head.target).substr(scheme.size(), end - scheme.size()));
  head.target.erase(0, end);
  if (!head.target.starts_with('/')) head.target.insert(0, 1, '/');
}

std::optional<Refusal> parse_target(std::string_view target, Head& head) {
  if (target.size() > max_target_bytes)
    return Refusal{414, "uri_too_long", "the target exceeds 4096 bytes", ""};
  const auto is_target_char = [](char c) { return c > 0x20 && c < 0x7F && c != '#'; };
  head.target = target;
  take_authority(head);
  if (!head.target.starts_with('/') || head.authority.find('@') != std::string::npos ||
      !std::all_of(target.begin(), target.end(), is_target_char))
    return malformed("the target is neither an absolute path nor an http URL");
  if (!percent_decode(head.target)) return malformed("the target holds a malformed escape");
  return std::nullopt;
}

std::optional<Refusal> parse_request_line(std::string_view line, Head& head) {
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return malformed("the request line is malformed");
  const std::string_view method = line.substr(0, first), version = line.substr(last + 1);
  if (method.empty() || method.size() > max_name_bytes ||
      !std::all_of(method.begin(), method.end(), is_token_char))
    return malformed("the method is malformed");
  if (version != "HTTP/1.1") {
    if (version.starts_with("HTTP/")) return Refusal{505, "http_version", "only HTTP/1.1 is spoken here", ""};
    return malformed("the request line is malformed");
  }
  head.method = method;
  return parse_target(line.substr(first + 1, last - first - 1), head);
}

std::optional<Refusal> parse_field(std::string_view line, Head& head) {
  const std::size_t colon = line.find(':');
  const std::string_view name = line.substr(0, colon);
  if (colon == std::string_view::npos || name.empty() ||
      !std::all_of(name.begin(), name.end(), is_token_char))
    return malformed("a header line is malformed");
  if (name.size() > max_name_bytes)
    return Refusal{431, "header_too_large", "the name of a header exceeds 256 bytes", ""};
  std::string_view value = line.substr(colon + 1);
  while (!value.empty() && (value.front() == ' ' || value.front() == '\t')) value.remove_prefix(1);
  while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.remove_suffix(1);
  if (head.fields.size() >= max_fields)
    return Refusal{431, "too_many_headers", "more than 64 header lines", ""};
  head.fields.emplace_back(lower_case(name), value);
  return std::nullopt;
}

std::optional<Refusal> parse_length(std::string_view text, Head& head) {
  if (head.declares_length) return malformed("more than one Content-Length");
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, head.content_length);
  if (error == std::errc::result_out_of_range) return Refusal{413, "too_large", "the body is too large", ""};
  if (error != std::errc() || stop != end) return malformed("Content-Length is not a number");
  head.declares_length = true;
  return std::nullopt;
}

std::optional<Refusal> check_framing(Head& head) {
  for (const auto& [name, value] : head.fields) {
    if (name == "content-length") {
      if (auto refusal = parse_length(value, head)) return refusal;
    } else if (name == "transfer-encoding") {
      return Refusal{411, "length_required", "Transfer-Encoding is not taken",
                     "declare the body's Content-Length"};
    } else if (name == "content-encoding") {
      return Refusal{415, "content_encoding", "compressed bodies are not taken", "send the body as it is"};
    } else if (name == "range") {
      return Refusal{416, "range", "ranges are not served", "ask for the whole"};
    } else if (name == "expect") {
      if (lower_case(value) != "100-continue") return Refusal{417, "expectation", "unknown expectation", ""};
      head.expects_continue = true;
    }
  }
  const bool may_have_body = head.method == "POST" || head.method == "PUT" || head.method == "PATCH";
  if (!may_have_body && head.content_length > 0) return malformed("a body where none belongs");
  return std::nullopt;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

}  // namespace

const std::string_view* Head::field(std::string_view lower_case_name) const {
  for (const auto& [name, value] : fields)
    if (name == lower_case_name) return &value;
  return nullptr;
}

std::size_t head_length(std::string_view bytes, std::size_t searched) {
  const std::size_t blank = bytes.find("\r\n\r\n", searched < 3 ? 0 : searched - 3);
  return blank == std::string_view::npos ? blank : blank + 4;
}

std::variant<Head, Refusal> check_head(std::string_view rest) {
  Head head;
  const auto request_line = take_line(rest);
  if (!request_line) return malformed("a control character in the request line");
  if (auto refusal = parse_request_line(*request_line, head)) return *refusal;
  for (;;) {
    const auto line = take_line(rest);
    if (!line) return malformed("a control character in a header line");
    if (line->empty()) break;
    if (auto refusal = parse_field(*line, head)) return *refusal;
  }
  if (auto refusal = check_framing(head)) return *refusal;
  return head;
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::optional<std::string> percent_decode(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0 || high + low == 0) return std::nullopt;
    out += static_cast<char>(high << 4 | low);
    i += 2;
  }
  return out;
}

}  // namespace isochor
