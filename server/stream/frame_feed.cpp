#include "server/stream/frame_feed.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/job_queue/retry_allocation.h"

namespace isochor {
namespace {

/// Enough for readers that are a frame or two apart.
constexpr std::size_t encoded_frames = 6;

std::int64_t size_of(const Snapshot& frame) {
  std::int64_t bytes = sizeof frame;
  for (const BodySnapshot& body : frame.bodies)
    bytes += static_cast<std::int64_t>(sizeof body + body.positions.size() * sizeof(Vec3));
  return bytes;
}

}  // namespace

FrameFeed::FrameFeed(std::shared_ptr<Waker> waker, std::shared_ptr<WorkerPool> encoder,
                     std::int64_t max_bytes)
    : waker_(std::move(waker)), encoder_(std::move(encoder)), max_bytes_(max_bytes) {}

void FrameFeed::post(Snapshot snapshot) {
  const auto frame = std::make_shared<const Snapshot>(std::move(snapshot));
  data_.with([&](Data& data) {
    data.frames.push_back(frame);
    data.bytes += size_of(*frame);
    while (data.frames.size() > 1 && data.bytes > max_bytes_) {
      data.bytes -= size_of(*data.frames.front());
      data.frames.pop_front();
    }
    data.status.first = data.frames.front()->seq;
    data.status.last = frame->seq;
    data.status.t = frame->t;
  });
  waker_->wake();
}

void FrameFeed::set_hello(EncodeHello encode) {
  data_.with([&](Data& data) {
    data.hello = std::make_shared<Hello>();
    data.hello->encode = std::move(encode);
    data.status.ready = true;
  });
  waker_->wake();
}

void FrameFeed::set_state(std::string_view state) {
  data_.with([&](Data& data) {
    data.status.state = state;
    ++data.status.version;
  });
  waker_->wake();
}

void FrameFeed::fail(std::string error_line) {
  data_.with([&](Data& data) { data.status.error_line = std::move(error_line); });
}

void FrameFeed::restart() {
  data_.with([](Data& data) {
    data.frames.clear();
    data.encoded.clear();
    data.under_way.clear();
    data.bytes = 0;
    data.status.first = 0;
    data.status.last = -1;
    data.status.t = 0.0;
    ++data.status.epoch;
  });
}

void FrameFeed::end(std::string reason) {
  data_.with([&](Data& data) {
    if (data.status.end_reason.empty()) data.status.end_reason = std::move(reason);
  });
  waker_->wake();
}

void FrameFeed::notify() const {
  waker_->wake();
}

FrameFeed::Status FrameFeed::status() const {
  return data_.with([](const Data& data) { return data.status; });
}

SharedBytes FrameFeed::hello(Encoding encoding, bool inline_topology) const {
  const auto hello = data_.with([](const Data& data) { return data.hello; });
  return hello->texts.get(fmt::format("{}/{}", static_cast<int>(encoding), inline_topology),
                          [&] { return hello->encode(encoding, inline_topology); });
}

const FrameFeed::EncodedFrame* FrameFeed::find_encoded(const Data& data, const Key& key) {
  for (const auto& [candidate, frame] : data.encoded)
    if (candidate == key) return &frame;
  return nullptr;
}

std::optional<FrameFeed::EncodedFrame> FrameFeed::newest(Encoding encoding, std::int64_t after,
                                                         std::int64_t stride) {
  return data_.with([&](Data& data) -> std::optional<EncodedFrame> {
    const auto wanted = [&](std::int64_t seq) { return seq > after && seq % stride == 0; };
    const auto latest = std::find_if(data.frames.rbegin(), data.frames.rend(),
                                     [&](const Frame& frame) { return wanted(frame->seq); });
    if (latest == data.frames.rend()) return std::nullopt;
    encode_later(data, {(*latest)->seq, encoding}, *latest);
    const EncodedFrame* best = nullptr;
    for (const auto& [key, frame] : data.encoded)
      if (key.second == encoding && wanted(key.first) && (!best || key.first > best->frame->seq))
        best = &frame;
    return best ? std::optional(*best) : std::nullopt;
  });
}

std::optional<FrameFeed::EncodedFrame> FrameFeed::following(Encoding encoding, std::int64_t after,
                                                            std::int64_t stride) {
  return data_.with([&](Data& data) -> std::optional<EncodedFrame> {
    const auto next = std::find_if(data.frames.begin(), data.frames.end(), [&](const Frame& frame) {
      return frame->seq > after && frame->seq % stride == 0;
    });
    if (next == data.frames.end()) return std::nullopt;
    const Key key{(*next)->seq, encoding};
    if (const EncodedFrame* found = find_encoded(data, key)) return *found;
    encode_later(data, key, *next);
    return EncodedFrame{*next, nullptr};
  });
}

/// One at a time an encoding: when it is done, readers ask again and get the newest of then.
void FrameFeed::encode_later(Data& data, const Key& key, const Frame& frame) {
  if (find_encoded(data, key) || !data.under_way.try_emplace(key.second, key).second) return;
  const bool queued = encoder_->submit([self = shared_from_this(), key, frame, epoch = data.status.epoch] {
    retry_allocation([&] { self->encode(key, frame, epoch); });
    self->waker_->wake();
  });
  if (!queued) data.under_way.erase(key.second);
}

void FrameFeed::encode(const Key& key, const Frame& frame, std::int64_t epoch) {
  EncodedFrame encoded{frame, std::make_shared<const std::string>(encode_frame_tail(*frame, key.second))};
  data_.with([&](Data& data) {
    if (data.status.epoch != epoch) return;
    data.encoded.emplace_back(key, std::move(encoded));
    if (data.encoded.size() > encoded_frames) data.encoded.pop_front();
    data.under_way.erase(key.second);
    ++data.encodes;
  });
}

FrameFeed::Frame FrameFeed::find(std::int64_t seq) const {
  return data_.with([&](const Data& data) -> Frame {
    const auto found = std::find_if(data.frames.begin(), data.frames.end(),
                                    [&](const Frame& frame) { return frame->seq == seq; });
    return found == data.frames.end() ? nullptr : *found;
  });
}

FrameFeed::Frame FrameFeed::latest() const {
  return data_.with([](const Data& data) { return data.frames.empty() ? nullptr : data.frames.back(); });
}

void FrameFeed::add_viewer(int change) {
  data_.with([&](Data& data) {
    data.viewers += change;
    data.left.reset();
    if (data.viewers == 0) data.left = std::chrono::steady_clock::now();
  });
}

int FrameFeed::viewers() const {
  return data_.with([](const Data& data) { return data.viewers; });
}

bool FrameFeed::left_alone(std::chrono::milliseconds time) const {
  return data_.with(
      [&](const Data& data) { return data.left && std::chrono::steady_clock::now() - *data.left >= time; });
}

std::int64_t FrameFeed::encodes() const {
  return data_.with([](const Data& data) { return data.encodes; });
}

std::int64_t FrameFeed::bytes() const {
  return data_.with([](const Data& data) { return data.bytes; });
}

}  // namespace isochor
