#pragma once
#include <memory>
#include <string>

#include "server/stream/frame_feed.h"

namespace isochor {

struct ViewerOptions {
  Encoding encoding = Encoding::f32;
  std::int64_t after_seq = -1;
  std::int64_t stride = 1;
  bool every = false;            ///< each buffered frame in turn, instead of the newest
  bool inline_topology = false;  ///< the hello line holds the bodies
  bool server_sent_events = false;
};

/// One reader of a feed: its lines in order, one at a time, when it is ready for the next.
class Viewer final : public ByteSource {
 public:
  Viewer(std::shared_ptr<FrameFeed> feed, const ViewerOptions& options);
  ~Viewer() override;

  StreamPiece next(std::chrono::steady_clock::time_point now) override;
  bool finished() const override { return finished_; }

 private:
  StreamPiece line(std::string text, std::string_view event);
  StreamPiece hello() const;
  StreamPiece frame(const FrameFeed::EncodedFrame& encoded);
  bool ended(const FrameFeed::Status& status) const;
  std::optional<StreamPiece> next_line(const FrameFeed::Status& status);
  std::optional<StreamPiece> next_frame();

  std::shared_ptr<FrameFeed> feed_;
  ViewerOptions options_;
  std::int64_t cursor_, dropped_ = 0;
  std::int64_t epoch_ = 0, version_ = 0;
  bool started_;  ///< has a frame, so that a gap counts as dropped
  bool greeted_ = false, error_sent_ = false, finished_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace isochor
