#include "core/parallel/cancel_scope.h"

#include <utility>

namespace isochor {
namespace {

thread_local const Progress* current = nullptr;

}  // namespace

CancelScope::CancelScope(const Progress& progress) : outer_(std::exchange(current, &progress)) {}

CancelScope::~CancelScope() {
  current = outer_;
}

const Progress* CancelScope::progress() {
  return current;
}

void throw_if_scope_cancelled() {
  if (current) current->throw_if_cancelled();
}

}  // namespace isochor
