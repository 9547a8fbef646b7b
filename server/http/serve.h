#pragma once
#include <cstdint>
#include <string>

namespace isochor {

struct ServeOptions {
  std::string host = "127.0.0.1";
  int port = 8080;    ///< 0: any free one
  std::string token;  ///< required for a host that is not loopback; otherwise made at launch
  bool json = false;  ///< print one line {"url":…,"token":…} on stdout
  std::string samples_folder, web_folder;
  std::int64_t memory_limit = std::int64_t{4} << 30;  ///< bytes of all models and simulations
};

/// Serves until SIGINT or SIGTERM; returns an exit code of server/problem.h.
int serve(const ServeOptions& options);

}  // namespace isochor
