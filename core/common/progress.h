#pragma once
#include <atomic>
#include <functional>
#include <string_view>
#include <utility>

#include "core/common/error.h"

namespace isochor {

/// The one small context of long work: it reports a fraction and learns of cancellation.
/// A default-constructed Progress reports to nobody and is never cancelled.
class Progress {
 public:
  /// phase is the name of the stage under way, fraction is in [0,1] within it. Called from the working
  /// thread.
  using Sink = std::function<void(std::string_view phase, double fraction)>;

  Progress() = default;
  explicit Progress(Sink sink, const std::atomic<bool>* cancel = nullptr)
      : sink_(std::move(sink)), cancel_(cancel) {}

  void report(std::string_view phase, double fraction) const {
    if (sink_) sink_(phase, fraction);
  }
  bool cancelled() const { return cancel_ && cancel_->load(std::memory_order_relaxed); }
  /// Reports to another sink, cancelled together with this one.
  Progress with_sink(Sink sink) const { return Progress(std::move(sink), cancel_); }
  /// Cheap enough for every few milliseconds of work.
  void throw_if_cancelled() const {
    if (cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
  }

 private:
  Sink sink_;
  const std::atomic<bool>* cancel_ = nullptr;
};

}  // namespace isochor
