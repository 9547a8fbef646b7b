#include "server/stream/viewer.h"

#include <fmt/format.h>

namespace isochor {
namespace {

constexpr auto heartbeat = std::chrono::seconds(2);

}  // namespace

Viewer::Viewer(std::shared_ptr<FrameFeed> feed, const ViewerOptions& options)
    : feed_(std::move(feed)),
      options_(options),
      cursor_(options.after_seq),
      epoch_(feed_->status().epoch),
      started_(options.after_seq >= 0) {
  feed_->add_viewer(1);
}

Viewer::~Viewer() {
  feed_->add_viewer(-1);
}

/// A line of NDJSON, or the same as a server-sent event: its newline, and one more, end the event.
StreamPiece Viewer::line(std::string text, std::string_view event) {
  if (options_.server_sent_events) text = fmt::format("event: {}\ndata: {}\n", event, text);
  return {std::move(text), nullptr, {}};
}

/// Of megabytes where the bodies are in it, and shared with whoever reads it at the same time.
StreamPiece Viewer::hello() const {
  SharedBytes text = feed_->hello(options_.encoding, options_.inline_topology);
  if (options_.server_sent_events) return {"event: hello\ndata: ", std::move(text), "\n"};
  return {{}, std::move(text), {}};
}

StreamPiece Viewer::next(std::chrono::steady_clock::time_point now) {
  if (finished_) return {};
  const FrameFeed::Status status = feed_->status();
  auto piece = next_line(status);
  if (!piece && greeted_) piece = next_frame();
  if (!piece && ended(status)) {
    finished_ = true;
    piece =
        line(encode_end(status.end_reason.empty() ? status.state : status.end_reason, status.last), "end");
  }
  if (!piece && greeted_ && now - last_ >= heartbeat)
    piece = line(encode_heartbeat(status.last, status.t), "heartbeat");
  if (!piece) return {};
  last_ = now;
  return std::move(*piece);
}

/// Whoever wants every frame has all of a finished run; others wait for a restart.
bool Viewer::ended(const FrameFeed::Status& status) const {
  if (!status.end_reason.empty()) return true;
  return options_.every && greeted_ && status.state == "finished" && cursor_ + options_.stride > status.last;
}

std::optional<StreamPiece> Viewer::next_line(const FrameFeed::Status& status) {
  if (!status.error_line.empty() && !error_sent_) {
    error_sent_ = true;
    return line(status.error_line, "error");
  }
  if (!status.ready) return std::nullopt;
  if (!greeted_) {
    greeted_ = true;
    return hello();
  }
  if (status.epoch != epoch_) {
    epoch_ = status.epoch;
    cursor_ = -1;
  }
  if (status.version != version_) {
    version_ = status.version;
    return line(encode_state(status.state, status.last, status.t), "state");
  }
  return std::nullopt;
}

std::optional<StreamPiece> Viewer::next_frame() {
  const auto encoded = options_.every ? feed_->following(options_.encoding, cursor_, options_.stride)
                                      : feed_->newest(options_.encoding, cursor_, options_.stride);
  if (!encoded || !encoded->tail) return std::nullopt;
  return frame(*encoded);
}

StreamPiece Viewer::frame(const FrameFeed::EncodedFrame& encoded) {
  const std::int64_t seq = encoded.frame->seq;
  // The first frame is where this reader came in: what went before was not meant for it.
  if (started_) dropped_ += (seq - cursor_) / options_.stride - 1;
  started_ = true;
  cursor_ = seq;
  std::string head = encode_frame_head(*encoded.frame, dropped_);
  if (!options_.server_sent_events) return {std::move(head), encoded.tail, {}};
  return {fmt::format("event: frame\nid: {}\ndata: {}", seq, head), encoded.tail, "\n"};
}

}  // namespace isochor
