#pragma once
#include <memory>
#include <string>
#include <thread>

#include "server/http/api.h"
#include "server/http/assets.h"
#include "server/http/front.h"
#include "server/http/serve.h"

namespace isochor {

/// Everything that serves, from the socket to the simulations, in the order in which it has to end.
class Server {
 public:
  /// Binds the port. Throws PortInUse, Error.
  explicit Server(const ServeOptions& options, const FrontLimits& limits = {});
  ~Server();

  int port() const { return listener_.port(); }
  std::string url() const;
  const std::string& token() const { return token_; }
  const std::vector<Route>& routes() const { return service_.routes(); }

  void run();   ///< until stop()
  void stop();  ///< from any thread; streams get their last line

 private:
  void warm();

  std::string host_;
  Listener listener_;
  std::string token_;
  std::shared_ptr<Waker> waker_;
  Api api_;
  Assets assets_;
  Service service_;
  Workers workers_;
  Front front_;
};

}  // namespace isochor
