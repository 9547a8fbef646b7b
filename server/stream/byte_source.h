#pragma once
#include <chrono>
#include <memory>
#include <string>

namespace isochor {

using SharedBytes = std::shared_ptr<const std::string>;

/// What a stream sends next: bytes that it shares with other readers, between some of this reader's own.
struct StreamPiece {
  std::string own;
  SharedBytes shared;
  std::string end;
  std::size_t size() const { return own.size() + (shared ? shared->size() : 0) + end.size(); }
  bool empty() const { return size() == 0; }
};

/// The slot of one reader of a stream. Asked by the thread that writes, only when the reader has taken
/// everything before, so that nothing queues up for a slow one.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Empty: nothing to send now, or finished().
  virtual StreamPiece next(std::chrono::steady_clock::time_point now) = 0;
  virtual bool finished() const = 0;
};

}  // namespace isochor
