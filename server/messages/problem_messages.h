#pragma once
#include <string>
#include <string_view>

#include "core/common/error.h"

namespace isochor {

/// RFC 9457 problem document of a failure: type, title, status, detail, code, hint, errors.
std::string encode_problem(const Error& error);

/// The same for what the server itself refuses (401, 403, 404, …).
struct Refusal {
  int status = 400;
  std::string code;    ///< stable, snake_case
  std::string detail;  ///< what and where
  std::string hint;    ///< what to do next
};
std::string encode_problem(const Refusal& refusal);

/// Thrown for what only a server can say (404, 409, 410, 429, 503).
struct RefusalException {
  Refusal refusal;
};

/// Reason phrase of a status, the problem's title.
std::string_view status_title(int status);

}  // namespace isochor
