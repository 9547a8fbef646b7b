#pragma once
#include "core/common/error.h"

namespace isochor {

/// Exit codes of the command line; 128 + SIGINT when interrupted.
enum ExitCode : int {
  exit_ok = 0,
  exit_internal = 1,
  exit_usage = 2,
  exit_cannot_read = 3,
  exit_unsupported = 4,
  exit_empty = 5,  ///< also a model that is written but incomplete
  exit_quality = 6,
  exit_budget = 7,
  exit_port_in_use = 8,
  exit_interrupted = 130,
};

/// The one place that maps what the library throws to what callers outside see.
struct ProblemMapping {
  const char* code;  ///< the problem document's "code"
  int exit_code;
  int http_status;
};
ProblemMapping problem_mapping(ErrorCode code);

/// What is being handled, as an Error: to be called in a catch block.
Error current_error();

}  // namespace isochor
