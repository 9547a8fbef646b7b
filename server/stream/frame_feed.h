#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/scene/snapshot.h"
#include "server/job_queue/guarded.h"
#include "server/job_queue/shared.h"
#include "server/job_queue/worker_pool.h"
#include "server/messages/frame_codec.h"
#include "server/stream/byte_source.h"
#include "server/stream/waker.h"

namespace isochor {

/// Between one simulation, which posts frames and never waits, and its readers, each of whom takes the
/// newest. Keeps the last frames for scrubbing, bounded in bytes, and encodes a frame once an encoding, on a
/// thread of its own, and only when somebody wants it.
class FrameFeed : public std::enable_shared_from_this<FrameFeed> {
 public:
  FrameFeed(std::shared_ptr<Waker> waker, std::shared_ptr<WorkerPool> encoder, std::int64_t max_bytes);

  using Frame = std::shared_ptr<const Snapshot>;
  struct EncodedFrame {
    Frame frame;
    SharedBytes tail;  ///< encode_frame_tail
  };

  // The simulation's side.
  void post(Snapshot frame);
  using EncodeHello = std::function<std::string(Encoding, bool inline_topology)>;
  void set_hello(EncodeHello encode);
  void set_state(std::string_view state);
  void fail(std::string error_line);  ///< sent before the end
  void restart();                     ///< forgets the frames; seq begins again
  void end(std::string reason);       ///< nothing follows
  void notify() const;                ///< something changed that the feed does not hold

  // The readers' side; every call is short.
  struct Status {
    std::string state, error_line, end_reason;
    std::int64_t version = 0;  ///< of the state
    std::int64_t epoch = 0;    ///< counts restarts
    bool ready = false;        ///< hello is there
    std::int64_t first = 0, last = -1;
    double t = 0.0;
  };
  Status status() const;
  SharedBytes hello(Encoding encoding, bool inline_topology) const;
  /// The newest encoded frame past `after` whose seq is a multiple of stride; asks for a newer one when there
  /// is.
  std::optional<EncodedFrame> newest(Encoding encoding, std::int64_t after, std::int64_t stride);
  /// The first buffered frame past `after`, for those who want every one; null tail: not encoded yet.
  std::optional<EncodedFrame> following(Encoding encoding, std::int64_t after, std::int64_t stride);
  Frame find(std::int64_t seq) const;
  Frame latest() const;

  void add_viewer(int change);
  int viewers() const;
  bool left_alone(std::chrono::milliseconds time) const;  ///< the last viewer went that long ago
  std::int64_t encodes() const;
  std::int64_t bytes() const;

 private:
  using Key = std::pair<std::int64_t, Encoding>;
  struct Hello {
    EncodeHello encode;
    Shared<std::string> texts;
  };
  struct Data {
    Status status;
    std::shared_ptr<Hello> hello;
    std::deque<Frame> frames;
    std::int64_t bytes = 0, encodes = 0;
    std::deque<std::pair<Key, EncodedFrame>> encoded;  ///< the last few
    std::map<Encoding, Key> under_way;
    int viewers = 0;
    std::optional<std::chrono::steady_clock::time_point> left;  ///< when the last viewer went
  };
  void encode_later(Data& data, const Key& key, const Frame& frame);
  void encode(const Key& key, const Frame& frame, std::int64_t epoch);
  static const EncodedFrame* find_encoded(const Data& data, const Key& key);

  std::shared_ptr<Waker> waker_;
  std::shared_ptr<WorkerPool> encoder_;
  const std::int64_t max_bytes_;
  Guarded<Data> data_;
};

}  // namespace isochor
