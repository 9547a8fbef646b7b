#pragma once
#include <thread>

#include "server/http/server.h"
#include "tests/support/http_client.h"

namespace isochor::test {

/// The real server on a free port, in this process.
class RunningServer {
 public:
  explicit RunningServer(ServeOptions options = {}, const FrontLimits& limits = {})
      : server_(with_folders(std::move(options)), limits), thread_([this] { server_.run(); }) {}
  ~RunningServer() {
    server_.stop();
    thread_.join();
  }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  HttpClient client() const { return {server_.port(), server_.token()}; }
  Server& server() { return server_; }

 private:
  static ServeOptions with_folders(ServeOptions options) {
    options.port = 0;
    options.samples_folder = ISOCHOR_SAMPLES;
    if (options.web_folder.empty()) options.web_folder = ISOCHOR_SOURCE "/web";
    return options;
  }

  Server server_;
  std::thread thread_;
};

}  // namespace isochor::test
