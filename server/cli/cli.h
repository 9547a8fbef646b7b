#pragma once

namespace isochor {

/// The command line: parses, runs one command, maps every failure to an exit code (server/problem.h).
int run_cli(int argc, char** argv);

}  // namespace isochor
