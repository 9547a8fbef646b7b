#include "server/problem.h"

#include <exception>
#include <new>

namespace isochor {

ProblemMapping problem_mapping(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
      return {"invalid_argument", exit_usage, 422};
    case ErrorCode::cannot_read:
      return {"cannot_read", exit_cannot_read, 422};
    case ErrorCode::cannot_write:
      return {"cannot_write", exit_internal, 500};
    case ErrorCode::unsupported_format:
      return {"unsupported_format", exit_unsupported, 415};
    case ErrorCode::empty_result:
      return {"empty_result", exit_empty, 422};
    case ErrorCode::quality_gate:
      return {"quality_gate", exit_quality, 422};
    case ErrorCode::over_budget:
      return {"over_budget", exit_budget, 422};
    case ErrorCode::cancelled:
      return {"cancelled", exit_interrupted, 409};
    case ErrorCode::internal:
      break;
  }
  return {"internal", exit_internal, 500};
}

Error current_error() {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return {ErrorCode::over_budget, "the memory does not suffice", "ask for fewer voxels or cells"};
  } catch (const std::exception& exception) {
    return {ErrorCode::internal, exception.what()};
  }
}

}  // namespace isochor
