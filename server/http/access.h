#pragma once
#include <optional>
#include <string>
#include <vector>

#include "server/http/head_check.h"
#include "server/http/message.h"

namespace isochor {

/// Who may ask. The server runs on a person's own machine, where every web page that the person opens can
/// reach it, under its own name (DNS rebinding) or by requests that it sends along (cross-site forgery).
struct AccessPolicy {
  std::vector<std::string> hosts;  ///< Host in lower case; empty: any, for an address that is not loopback
  std::string token;               ///< of this launch
  bool token_for_reading = false;  ///< not loopback: everything of the API needs it
};

/// Loopback names with this port, and the name that the server was told to listen at.
AccessPolicy loopback_policy(int port, std::string token, const std::string& name = "localhost");

/// Host, the target's own authority, Origin and Sec-Fetch-Site; nullopt when they are in order.
std::optional<Refusal> check_origin(const Head& head, const AccessPolicy& policy);

/// Authorization: Bearer, compared in constant time.
std::optional<Refusal> check_token(const Head& head, const AccessPolicy& policy);

/// Whether a browser trusts where it reached us: at loopback, or over TLS, of which a proxy tells.
bool has_trustworthy_origin(const Request& request);

/// 32 random bytes in hexadecimal.
std::string make_token();

}  // namespace isochor
