#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/messages/problem_messages.h"

namespace isochor {

/// Bounds on the head of a request; a head beyond them is refused as it arrives.
inline constexpr std::size_t max_head_bytes = 16 * 1024, max_target_bytes = 4096, max_fields = 64,
                             max_name_bytes = 256;

/// A head that can be read in one way only (RFC 9112, and stricter where proxies and libraries differ).
/// Values are views of its bytes: no copy of what may be long, and refused.
struct Head {
  std::string method;
  std::string authority;  ///< in lower case, of an absolute target (RFC 9112, 3.2.2); else empty
  std::string target;     ///< origin form
  std::vector<std::pair<std::string, std::string_view>> fields;  ///< names in lower case
  std::size_t content_length = 0;
  bool declares_length = false;
  bool expects_continue = false;

  const std::string_view* field(std::string_view lower_case_name) const;
};

/// Length of the head with its blank line; npos while it is incomplete. The first `searched` bytes have been
/// looked at before.
std::size_t head_length(std::string_view bytes, std::size_t searched = 0);

/// head: all of it, with its blank line. Refuses what could be read in two ways (bare line feeds, folded
/// lines, two lengths, Transfer-Encoding, a GET with a body) and what the server does not do (Range,
/// Content-Encoding).
std::variant<Head, Refusal> check_head(std::string_view head);

/// The letters of ASCII only, as names of headers and hosts compare.
std::string lower_case(std::string_view text);

/// %XX decoded; empty when an escape is malformed or encodes NUL.
std::optional<std::string> percent_decode(std::string_view text);

}  // namespace isochor
