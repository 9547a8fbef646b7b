#include "server/stream/frame_feed.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "server/stream/simulation_runner.h"
#include "server/stream/viewer.h"
#include "tests/support/fake_simulation.h"
#include "tests/support/typed_array.h"

namespace isochor {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

Snapshot frame(std::int64_t seq, std::size_t vertices = 1) {
  Snapshot made;
  made.seq = seq;
  made.bodies.resize(1);
  made.bodies[0].positions.assign(vertices, Vec3(static_cast<double>(seq), 0.0, 0.0));
  return made;
}

constexpr std::int64_t buffer_bytes = 50000;

class Feed : public testing::Test {
 protected:
  Feed() {
    feed_->set_hello([](Encoding, bool) { return std::string("{\"type\":\"hello\"}\n"); });
    feed_->set_state("playing");
  }
  /// The next line that comes, as the front would ask for it.
  json next(Viewer& viewer) {
    for (int patience = 0; patience < 20000; ++patience) {
      const StreamPiece piece = viewer.next(Clock::now());
      if (!piece.empty()) return json::parse(piece.own + (piece.shared ? *piece.shared : "") + piece.end);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return nullptr;
  }
  json next_frame(Viewer& viewer) {
    for (;;) {
      json line = next(viewer);
      if (line.is_null() || line["type"] == "frame") return line;
    }
  }

  std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();
  std::shared_ptr<WorkerPool> encoder_ = std::make_shared<WorkerPool>(1);
  std::shared_ptr<FrameFeed> feed_ = std::make_shared<FrameFeed>(waker_, encoder_, buffer_bytes);
};

TEST_F(Feed, LinesComeInOrder) {
  feed_->post(frame(0));
  Viewer viewer(feed_, {});
  EXPECT_EQ(next(viewer)["type"], "hello");
  EXPECT_EQ(next(viewer)["state"], "playing");
  EXPECT_EQ(next(viewer)["seq"], 0);
  feed_->set_state("paused");
  feed_->post(frame(1));
  EXPECT_EQ(next(viewer)["state"], "paused");
  EXPECT_EQ(next(viewer)["seq"], 1);
  feed_->end("deleted");
  EXPECT_EQ(next(viewer)["reason"], "deleted");
  EXPECT_TRUE(viewer.finished());
  EXPECT_TRUE(viewer.next(Clock::now()).empty());
}

TEST_F(Feed, TheNewestWinsAndWhatWasSkippedIsCounted) {
  feed_->post(frame(0));
  Viewer viewer(feed_, {});
  EXPECT_EQ(next_frame(viewer)["dropped"], 0);
  for (int seq = 1; seq <= 7; ++seq) feed_->post(frame(seq));
  const json late = next_frame(viewer);
  EXPECT_EQ(late["seq"], 7);
  EXPECT_EQ(late["dropped"], 6);
  feed_->post(frame(8));
  EXPECT_EQ(next_frame(viewer)["dropped"], 6);
}

TEST_F(Feed, OneEncodeServesAllViewers) {
  std::vector<std::unique_ptr<Viewer>> viewers;
  for (int i = 0; i < 50; ++i) viewers.push_back(std::make_unique<Viewer>(feed_, ViewerOptions{}));
  for (auto& viewer : viewers) EXPECT_EQ(next(*viewer)["type"], "hello");
  const std::string* shared = nullptr;
  feed_->post(frame(0));
  for (auto& viewer : viewers) {
    StreamPiece piece;
    while (!piece.shared) piece = viewer->next(Clock::now());
    if (!shared) shared = piece.shared.get();
    EXPECT_EQ(piece.shared.get(), shared);
  }
  EXPECT_EQ(feed_->encodes(), 1);
  EXPECT_EQ(feed_->viewers(), 50);
  viewers.clear();
  EXPECT_EQ(feed_->viewers(), 0);
}

TEST_F(Feed, SlowReadersShareTheirFirstLine) {
  std::vector<SharedBytes> held;
  for (int i = 0; i < 10; ++i)
    held.push_back(Viewer(feed_, {.inline_topology = true}).next(Clock::now()).shared);
  for (const SharedBytes& line : held) EXPECT_EQ(line, held.front());
  EXPECT_EQ(Viewer(feed_, {.server_sent_events = true}).next(Clock::now()).own, "event: hello\ndata: ");
}

TEST_F(Feed, NobodyLooksNothingIsEncoded) {
  for (int seq = 0; seq < 20; ++seq) feed_->post(frame(seq));
  EXPECT_EQ(feed_->encodes(), 0);
}

TEST_F(Feed, EveryFrameForThoseWhoRecord) {
  for (int seq = 0; seq < 5; ++seq) feed_->post(frame(seq));
  Viewer viewer(feed_, {.every = true});
  for (int seq = 0; seq < 5; ++seq) EXPECT_EQ(next_frame(viewer)["seq"], seq);
  Viewer later(feed_, {.after_seq = 2, .every = true});
  EXPECT_EQ(next_frame(later)["seq"], 3);
  feed_->set_state("finished");
  EXPECT_EQ(next_frame(later)["seq"], 4);
  EXPECT_EQ(next(later)["reason"], "finished");
}

TEST_F(Feed, StridesSkipWithoutDropping) {
  for (int seq = 0; seq < 9; ++seq) feed_->post(frame(seq));
  Viewer viewer(feed_, {.stride = 4});
  EXPECT_EQ(next_frame(viewer)["seq"], 8);
  for (int seq = 9; seq < 13; ++seq) feed_->post(frame(seq));
  const json line = next_frame(viewer);
  EXPECT_EQ(line["seq"], 12);
  EXPECT_EQ(line["dropped"], 0);
}

TEST_F(Feed, TheBufferIsBoundedInBytes) {
  for (int seq = 0; seq < 100; ++seq) feed_->post(frame(seq, 100));
  EXPECT_LE(feed_->bytes(), buffer_bytes);
  const auto status = feed_->status();
  EXPECT_EQ(status.last, 99);
  EXPECT_GT(status.first, 70);
  EXPECT_EQ(feed_->find(0), nullptr);
  EXPECT_EQ(feed_->find(status.first)->seq, status.first);
}

TEST_F(Feed, ARestartBeginsAgain) {
  for (int seq = 0; seq < 5; ++seq) feed_->post(frame(seq));
  Viewer viewer(feed_, {});
  EXPECT_EQ(next_frame(viewer)["seq"], 4);
  feed_->restart();
  feed_->post(frame(0));
  EXPECT_EQ(next_frame(viewer)["seq"], 0);
}

TEST_F(Feed, SilenceIsBrokenByHeartbeats) {
  Viewer viewer(feed_, {});
  next(viewer), next(viewer);
  const auto now = Clock::now();
  EXPECT_TRUE(viewer.next(now).empty());
  EXPECT_EQ(json::parse(viewer.next(now + std::chrono::milliseconds(2100)).own)["type"], "heartbeat");
  EXPECT_TRUE(viewer.next(now + std::chrono::milliseconds(2200)).empty());
}

TEST_F(Feed, ARunnerPostsWhatItsSimulationMakes) {
  SimulationRunner runner(
      [](Progress&) { return std::make_unique<test::FakeSimulation>(Vec3i(1, 1, 1), 0.5, 20); },
      {.id = "s1", .fast = true, .playing = true}, feed_);
  Viewer viewer(feed_, {.every = true});
  for (int seq = 0; seq <= 20; ++seq) {
    const json line = next_frame(viewer);
    EXPECT_EQ(line["seq"], seq);
    EXPECT_EQ(test::decode_typed_array<float>(line["bodies"][0]["positions"])[1],
              static_cast<float>(test::FakeSimulation::lift * seq));
  }
  EXPECT_EQ(next(viewer)["reason"], "finished");
  EXPECT_EQ(runner.view().state, RunState::finished);
}

TEST_F(Feed, AnEndlessRunPausesWhenAllItsViewersHaveGone) {
  constexpr std::chrono::milliseconds patience(50);
  SimulationRunner runner(
      [](Progress&) { return std::make_unique<test::FakeSimulation>(Vec3i(1, 1, 1), 0.5, 1 << 30); },
      {.id = "s1", .playing = true, .patience = patience}, feed_);
  const auto state_after = [&](std::chrono::milliseconds time) {
    std::this_thread::sleep_for(time);
    return runner.view().state;
  };
  const auto await_pause = [&] {
    for (int tries = 0; tries < 1000; ++tries)
      if (state_after(std::chrono::milliseconds(10)) == RunState::paused) return true;
    return false;
  };
  {
    Viewer viewer(feed_, {});
    EXPECT_FALSE(next_frame(viewer).is_null());
    EXPECT_EQ(state_after(3 * patience), RunState::playing) << "it is watched";
  }
  EXPECT_TRUE(await_pause());
  const std::int64_t last = feed_->status().last;
  // Where threads starve its patience may be over before it is looked at, or before its first frame.
  for (int tries = 0; tries < 20 && feed_->status().last == last; ++tries) {
    runner.play();
    while (runner.view().taken < runner.requests()) std::this_thread::yield();
    EXPECT_TRUE(await_pause());
  }
  EXPECT_GT(feed_->status().last, last) << "it was asked for";
}

TEST_F(Feed, ARunThatNobodyHasWatchedGoesOn) {
  SimulationRunner runner(
      [](Progress&) { return std::make_unique<test::FakeSimulation>(Vec3i(1, 1, 1), 0.5, 1 << 30); },
      {.id = "s1", .playing = true, .patience = std::chrono::milliseconds(1)}, feed_);
  while (feed_->status().last < 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(runner.view().state, RunState::playing);
}

TEST_F(Feed, ARunnerThatCannotPrepareSaysWhy) {
  SimulationRunner runner(
      [](Progress&) -> std::unique_ptr<Simulation> {
        throw Error(ErrorCode::empty_result, "nothing inside");
      },
      {.id = "s1"}, feed_);
  Viewer viewer(feed_, {});
  json line = next(viewer);
  while (line["type"] != "error") line = next(viewer);
  EXPECT_EQ(line["problem"]["code"], "empty_result");
  while (line["type"] != "end") line = next(viewer);
  EXPECT_EQ(runner.view().failure->code(), ErrorCode::empty_result);
}

TEST_F(Feed, ARunnerIsCancelledWhilePreparing) {
  std::atomic<bool> entered{false};
  auto runner = std::make_unique<SimulationRunner>(
      [&](Progress& progress) -> std::unique_ptr<Simulation> {
        entered = true;
        for (;;) progress.throw_if_cancelled();
      },
      RunOptions{.id = "s1"}, feed_);
  while (!entered) std::this_thread::yield();
  runner.reset();
  EXPECT_EQ(feed_->status().end_reason, "deleted");
}

}  // namespace
}  // namespace isochor
