#include "server/http/listener.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <memory>

#include "core/common/error.h"

namespace isochor {
namespace {

struct FreeAddress {
  void operator()(addrinfo* address) const { freeaddrinfo(address); }
};

std::unique_ptr<addrinfo, FreeAddress> resolve(const std::string& host, int port) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
    throw Error(ErrorCode::invalid_argument, fmt::format("no address for host '{}'", host),
                "use 127.0.0.1, or an address of this machine");
  return std::unique_ptr<addrinfo, FreeAddress>(found);
}

bool is_loopback(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24 == 127;
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

int port_of(const sockaddr_storage& address) {
  return ntohs(address.ss_family == AF_INET ? reinterpret_cast<const sockaddr_in&>(address).sin_port
                                            : reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
}

void set_option(int socket, int level, int name, int value) {
  setsockopt(socket, level, name, &value, sizeof value);
}

}  // namespace

Listener::Listener(const std::string& host, int port) {
  const auto address = resolve(host, port);
  descriptor_ = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  set_option(descriptor_, SOL_SOCKET, SO_REUSEADDR, 1);
  // Connections inherit these. What the kernel holds for a slow reader is bounded, and newer frames replace
  // what was not sent yet.
  set_option(descriptor_, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(descriptor_, SOL_SOCKET, SO_SNDBUF, 256 * 1024);
  if (bind(descriptor_, address->ai_addr, address->ai_addrlen) != 0 || listen(descriptor_, SOMAXCONN) != 0) {
    const int reason = errno;
    close(descriptor_);
    if (reason == EADDRINUSE) throw PortInUse{port};
    throw Error(ErrorCode::invalid_argument,
                fmt::format("cannot listen on {} port {}: {}", host, port, std::strerror(reason)),
                "choose another --host or --port");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(descriptor_, reinterpret_cast<sockaddr*>(&bound), &size);
  port_ = port_of(bound);
  loopback_ = is_loopback(bound);
}

Listener::~Listener() {
  close(descriptor_);
}

}  // namespace isochor
