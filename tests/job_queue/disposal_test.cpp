#include "server/job_queue/disposal.h"

#include <gtest/gtest.h>

#include <thread>

namespace isochor {
namespace {

/// Takes until it is let go to end, as gigabytes take their time.
struct Slow {
  std::atomic<bool>& let_go;
  std::atomic<std::thread::id>& ended_on;
  ~Slow() {
    while (!let_go) std::this_thread::yield();
    ended_on = std::this_thread::get_id();
  }
};

class Disposed : public testing::Test {
 protected:
  std::shared_ptr<Slow> slow() {
    return disposal_.share(std::unique_ptr<Slow>(new Slow{let_go_, ended_on_}));
  }

  std::atomic<bool> let_go_{false};
  std::atomic<std::thread::id> ended_on_{};
  Disposal disposal_;
};

TEST_F(Disposed, WhoDropsTheLastReferenceDoesNotWait) {
  auto first = slow();
  auto second = first;
  first.reset();
  disposal_.wait(Progress());  // somebody holds it: nothing came
  second.reset();
  EXPECT_EQ(ended_on_.load(), std::thread::id());
  let_go_ = true;
  disposal_.wait(Progress());
  EXPECT_NE(ended_on_.load(), std::thread::id());
  EXPECT_NE(ended_on_.load(), std::this_thread::get_id());
}

TEST_F(Disposed, WaitingForItCanBeCancelled) {
  slow().reset();
  const std::atomic<bool> cancelled{true};
  EXPECT_THROW(disposal_.wait(Progress({}, &cancelled)), Error);
  let_go_ = true;
}

TEST_F(Disposed, WhatHoldsAnotherTakesItAlong) {
  struct Pair {
    std::shared_ptr<Slow> other;
  };
  let_go_ = true;
  disposal_.share(std::make_unique<Pair>(Pair{slow()})).reset();
  disposal_.wait(Progress());
  EXPECT_NE(ended_on_.load(), std::thread::id());
}

TEST(Disposal, GoesWithWhatStillWaits) {
  std::atomic<bool> let_go{false};
  std::atomic<std::thread::id> ended_on{};
  std::thread opener;
  {
    Disposal disposal;
    struct Pair {
      std::shared_ptr<Slow> other;
    };
    disposal.share(std::unique_ptr<Slow>(new Slow{let_go, ended_on})).reset();
    for (int i = 0; i < 3; ++i) {
      auto held = disposal.share(std::unique_ptr<Slow>(new Slow{let_go, ended_on}));
      disposal.share(std::make_unique<Pair>(Pair{std::move(held)})).reset();
    }
    opener = std::thread([&] { let_go = true; });
  }
  EXPECT_NE(ended_on.load(), std::thread::id());
  opener.join();
}

}  // namespace
}  // namespace isochor
