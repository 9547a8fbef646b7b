#include "server/http/access.h"

#include <sys/random.h>

#include <algorithm>
#include <array>

#include "core/common/error.h"

namespace isochor {
namespace {

std::vector<std::string_view> values(const Head& head, std::string_view name) {
  std::vector<std::string_view> found;
  for (const auto& [field, value] : head.fields)
    if (field == name) found.push_back(value);
  return found;
}

std::optional<Refusal> check_host(const std::string& host, const AccessPolicy& policy) {
  const bool known = policy.hosts.empty() ? !host.empty() : std::ranges::count(policy.hosts, host) == 1;
  if (known) return std::nullopt;
  return Refusal{421, "host", "this server does not answer to that Host",
                 "use the URL that the server printed"};
}

/// Behind a proxy that ends TLS the page's own origin is https.
bool is_own_origin(std::string_view origin, const std::string& host, const AccessPolicy& policy) {
  return origin == "http://" + host || (policy.hosts.empty() && origin == "https://" + host);
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

}  // namespace

AccessPolicy loopback_policy(int port, std::string token, const std::string& name) {
  AccessPolicy policy;
  policy.token = std::move(token);
  for (const std::string& host :
       {std::string("127.0.0.1"), std::string("localhost"), std::string("[::1]"), lower_case(name)}) {
    if (std::ranges::count(policy.hosts, host + ":" + std::to_string(port)) > 0) continue;
    policy.hosts.push_back(host + ":" + std::to_string(port));
    if (port == 80) policy.hosts.push_back(host);
  }
  return policy;
}

std::optional<Refusal> check_origin(const Head& head, const AccessPolicy& policy) {
  const auto hosts = values(head, "host");
  if (hosts.size() != 1) return Refusal{400, "host", "exactly one Host is needed", ""};
  // Names of hosts have no case (RFC 9110, 4.2.3), and none is so long.
  std::string host = lower_case(hosts.front().substr(0, max_name_bytes));
  if (auto refusal = check_host(host, policy)) return refusal;
  // Of an absolute target its own counts (RFC 9112, 3.2.2); no other name gets in by either.
  if (!head.authority.empty()) {
    host = head.authority;
    if (auto refusal = check_host(host, policy)) return refusal;
  }
  for (const std::string_view origin : values(head, "origin"))
    if (!is_own_origin(origin, host, policy))
      return Refusal{403, "origin", "requests from other origins are refused",
                     "open the page that this server serves"};
  for (const std::string_view site : values(head, "sec-fetch-site"))
    if (site != "same-origin" && site != "none")
      return Refusal{403, "cross_site", "requests that another site caused are refused",
                     "type the address into the browser instead"};
  return std::nullopt;
}

std::optional<Refusal> check_token(const Head& head, const AccessPolicy& policy) {
  constexpr std::string_view scheme = "bearer ";  // in any case (RFC 9110, 11.1)
  const auto given = values(head, "authorization");
  if (given.size() == 1 && lower_case(given.front().substr(0, scheme.size())) == scheme &&
      equal_in_constant_time(given.front().substr(scheme.size()), policy.token))
    return std::nullopt;
  return Refusal{401, "token", "a request that changes state needs this launch's token",
                 "send Authorization: Bearer with the token that the server printed or put into its page"};
}

bool has_trustworthy_origin(const Request& request) {
  const std::string* scheme = request.header("x-forwarded-proto");
  if (scheme) return *scheme == "https";
  const std::string* host = request.header("host");
  if (!host) return false;
  const std::string name = lower_case(host->substr(0, host->rfind(':')));
  return name == "127.0.0.1" || name == "localhost" || name == "[::1]";
}

std::string make_token() {
  std::array<unsigned char, 32> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error(ErrorCode::internal, "no random bytes for the token");
  std::string token;
  for (const unsigned char byte : bytes) {
    token += "0123456789abcdef"[byte >> 4];
    token += "0123456789abcdef"[byte & 15];
  }
  return token;
}

}  // namespace isochor
