#include "server/cli/cli.h"

#include <cstdio>

#include "server/problem.h"

namespace isochor {

int run_cli(int, char**) {
  std::fputs("usage: isochor COMMAND\n", stderr);
  return exit_usage;
}

}  // namespace isochor
