#pragma once
#include <string>

namespace isochor {

/// A listening socket: SO_REUSEADDR, so that a restart finds its port again, but not SO_REUSEPORT, so that a
/// second instance is told.
class Listener {
 public:
  /// port 0: any free one. Throws PortInUse, or Error for an address that cannot be had.
  Listener(const std::string& host, int port);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int descriptor() const { return descriptor_; }
  int port() const { return port_; }
  bool loopback() const { return loopback_; }

 private:
  int descriptor_ = -1;
  int port_ = 0;
  bool loopback_ = false;
};

struct PortInUse {
  int port;
};

}  // namespace isochor
