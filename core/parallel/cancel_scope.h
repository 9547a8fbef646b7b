#pragma once
#include "core/common/progress.h"

namespace isochor {

/// While it lives, long work on this thread ends soon after its progress is cancelled, though nobody hands
/// the progress down to the loops: parallel_for throws cancelled before each chunk. What was being changed
/// then is left half done.
class CancelScope {
 public:
  explicit CancelScope(const Progress& progress);
  explicit CancelScope(const Progress&&) = delete;
  ~CancelScope();
  CancelScope(const CancelScope&) = delete;
  CancelScope& operator=(const CancelScope&) = delete;

  /// That of this thread's innermost scope, or null.
  static const Progress* progress();

 private:
  const Progress* outer_;
};

/// For long serial loops: throws cancelled when the scope of this thread is. Cheap.
void throw_if_scope_cancelled();

}  // namespace isochor
