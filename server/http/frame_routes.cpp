#include <fmt/format.h>

#include <array>
#include <charconv>
#include <optional>

#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/api_messages.h"
#include "server/stream/viewer.h"

namespace isochor {
namespace {

constexpr int max_viewers = 256;

Response get_topology(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const auto facts = prepared(*runner);
  const std::string& id = request.segment("id");
  // Its id would not do for a tag: another launch has another simulation of this id.
  return shared_answer(api, id + "/topology", "",
                       [&](const TextSink& sink) { encode_topology(id, facts->bodies, sink); });
}

Encoding encoding_of(const Request& request) {
  constexpr std::array choices{Encoding::f32, Encoding::f64, Encoding::array};
  return choices[query_choice(request, "encoding", {"f32", "f64", "array"}, 0)];
}

constexpr std::int64_t max_seq = std::int64_t{1} << 53;

std::optional<std::int64_t> read_seq(const std::string& text) {
  std::int64_t seq = -1;
  const char* const stop = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), stop, seq);
  if (error != std::errc() || end != stop || seq < 0 || seq > max_seq) return std::nullopt;
  return seq;
}

Response get_frames(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  ViewerOptions options;
  options.encoding = encoding_of(request);
  options.after_seq = query_integer(request, "after_seq", -1, -1, max_seq);
  options.stride = query_integer(request, "stride", 1, 1, 1000000);
  options.every = query_choice(request, "pace", {"latest", "every"}, 0) == 1;
  options.inline_topology = query_choice(request, "topology", {"url", "inline"}, 0) == 1;
  const std::string* accept = request.header("accept");
  options.server_sent_events = accept && accept->find("text/event-stream") != std::string::npos;
  // A reader that comes back says where it was.
  if (const std::string* last = request.header("last-event-id"); last && !request.parameter("after_seq"))
    options.after_seq = read_seq(*last).value_or(options.after_seq);
  if (api.simulations.viewers() >= max_viewers)
    refuse(429, "too_many_streams", fmt::format("{} streams are open", max_viewers), "close some");
  Response response;
  response.content_type = options.server_sent_events ? "text/event-stream" : "application/x-ndjson";
  response.stream = std::make_shared<Viewer>(runner->feed(), options);
  return response;
}

Response get_frame(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const auto seq = read_seq(request.segment("seq"));
  if (!seq) refuse(404, "not_found", "a frame is named by its seq", "");
  const FrameFeed::Status status = runner->feed()->status();
  const auto frame = runner->feed()->find(*seq);
  if (!frame && *seq <= status.last)
    refuse(410, "evicted", fmt::format("frame {} has been evicted", *seq),
           fmt::format("frames {} to {} are buffered", status.first, status.last));
  if (!frame) refuse(404, "not_found", fmt::format("frame {} has not been made yet", *seq), "");
  const Encoding encoding = encoding_of(request);
  const std::string key = fmt::format("{}/frames/{}/{}/{}", request.segment("id"), status.epoch, *seq,
                                      static_cast<int>(encoding));
  return shared_answer(api, key, "", [&](const TextSink& sink) { sink(encode_frame(*frame, encoding)); });
}

constexpr std::string_view encoding_schema = R"({"enum":["f32","f64","array"],"default":"f32"})";

}  // namespace

std::vector<Route> frame_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/frames",
       .operation = "streamFrames",
       .summary = "The live stream: JSON lines, or server-sent events",
       .handler = to(get_frames),
       .answers = {{200, "StreamLine", "application/x-ndjson"}, {200, "", "text/event-stream"}},
       .query = {{"after_seq", R"({"type":"integer","minimum":-1})", "Frames after this one"},
                 {"stride", R"({"type":"integer","minimum":1})", "Only multiples of it"},
                 {"encoding", encoding_schema, "How positions are written"},
                 {"pace", R"({"enum":["latest","every"]})",
                  "Skip what is too late, or send every buffered frame"},
                 {"topology", R"({"enum":["url","inline"]})", "inline: the stream is a recording"}}},
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/frames/{seq}",
       .operation = "getFrame",
       .summary = "One buffered frame",
       .handler = to(get_frame),
       .answers = {{200, "StreamLine"}},
       .query = {{"encoding", encoding_schema, "How positions are written"}}},
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/topology",
       .operation = "getTopology",
       .summary = "The bodies: tets, cells, rest positions, masses, surface, embedding",
       .handler = to(get_topology),
       .answers = {{200, "Topology"}}},
  };
}

}  // namespace isochor
