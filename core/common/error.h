#pragma once
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace isochor {

/// What went wrong, in terms that a caller can act on. The command line maps it to an exit code and the
/// server to an HTTP status; both tables stand in server/problem.h.
enum class ErrorCode {
  internal,            ///< a broken invariant of ours
  invalid_argument,    ///< a parameter, option or scene field out of range or unknown
  cannot_read,         ///< missing, truncated or malformed input
  cannot_write,        ///< the target cannot be written (disk full, no permission)
  unsupported_format,  ///< a file type nobody here reads or writes
  empty_result,        ///< nothing to work on, or nothing came out
  quality_gate,        ///< a result that falls short of what the caller required
  over_budget,         ///< memory, size or time above the limit; the hint names the largest setting that fits
  cancelled,
};

/// One faulty field: a JSON pointer into the request, scene or params file, and the allowed range if any.
struct ErrorDetail {
  std::string pointer;
  std::string detail;
  std::optional<double> min, max;
};

/// Every failure that leaves the library: what() says what and where, hint() what to do next.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& what, std::string hint = {}, std::vector<ErrorDetail> details = {})
      : std::runtime_error(what), code_(code), hint_(std::move(hint)), details_(std::move(details)) {}

  ErrorCode code() const { return code_; }
  const std::string& hint() const { return hint_; }
  const std::vector<ErrorDetail>& details() const { return details_; }

 private:
  ErrorCode code_;
  std::string hint_;
  std::vector<ErrorDetail> details_;
};

}  // namespace isochor
