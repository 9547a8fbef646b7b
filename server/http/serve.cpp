#include "server/http/serve.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "server/http/connection.h"
#include "server/http/server.h"
#include "server/messages/json.h"
#include "server/problem.h"

namespace isochor {
namespace {

/// A descriptor for each slow peer: as many as we may have, and a table with room for them. Once threads
/// share the table, the kernel halts who makes it grow for tens of milliseconds.
void make_room_for_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  constexpr rlim_t enough = 16384;
  const Socket any(epoll_create1(EPOLL_CLOEXEC));
  const Socket last(
      fcntl(any.descriptor(), F_DUPFD_CLOEXEC, static_cast<int>(std::min(limit.rlim_cur, enough)) - 1));
}

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

void announce(const Server& server, bool json) {
  if (json)
    fmt::print("{}\n", to_text({{"url", server.url()}, {"token", server.token()}}));
  else
    fmt::print("{}\n", server.url());
  std::fflush(stdout);
}

/// Out within a second whatever still runs: nothing that is saved depends on it.
void exit_late() {
  std::thread([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(750));
    std::_Exit(exit_ok);
  }).detach();
}

}  // namespace

int serve(const ServeOptions& options) try {
  make_room_for_descriptors();
  // Before any thread is made, so that all of them leave these signals to sigwait.
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  Server server(options);
  std::thread front([&] { server.run(); });
  announce(server, options.json);
  int signal = 0;
  sigwait(&signals, &signal);
  exit_late();
  server.stop();
  front.join();
  return exit_ok;
} catch (const PortInUse& in_use) {
  fmt::print(
      stderr,
      "error: port {} is in use\nhint: another Isochor may be running; choose a --port, or 0 for any\n",
      in_use.port);
  return exit_port_in_use;
}

}  // namespace isochor
