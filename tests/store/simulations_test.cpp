#include "server/store/simulations.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/stream/waker.h"

namespace isochor {
namespace {

/// Takes until it is let go to end, as gigabytes take their time.
class Slow {
 public:
  explicit Slow(std::atomic<bool>& let_go) : let_go_(let_go) {}
  ~Slow() {
    while (!let_go_) std::this_thread::yield();
  }
  Slow(const Slow&) = delete;
  Slow& operator=(const Slow&) = delete;

 private:
  std::atomic<bool>& let_go_;
};

class Room : public testing::Test {
 protected:
  static constexpr std::int64_t all = 1000;

  ~Room() override { let_go_ = true; }

  /// A simulation that has taken its room, stands still, and takes its time to be freed.
  std::string taken(std::int64_t bytes) {
    const auto build = [held = std::make_shared<Slow>(let_go_)](const std::string&,
                                                                Progress&) -> std::unique_ptr<Simulation> {
      throw Error(ErrorCode::invalid_argument, "nothing to build");
    };
    const auto runner = simulations_.create(build, {});
    while (runner->view().state == RunState::preparing) std::this_thread::yield();
    simulations_.make_room(runner->view().id, bytes, Progress());
    return runner->view().id;
  }

  /// What becomes of one that wants so much, and would not wait.
  std::string wanted(std::int64_t bytes) {
    const std::atomic<bool> impatient{true};
    try {
      simulations_.make_room("", bytes, Progress({}, &impatient));
    } catch (const Error& error) {
      return error.code() == ErrorCode::cancelled ? "waits" : "refused";
    }
    return "goes on";
  }

  std::atomic<bool> let_go_{false};
  Simulations simulations_{std::make_shared<Waker>(), all, all};
};

TEST_F(Room, WhatFitsBesideWhatIsBeingFreedDoesNotWaitForIt) {
  const std::string large = taken(700);
  simulations_.remove(large);
  EXPECT_EQ(wanted(300), "goes on");
  EXPECT_EQ(wanted(301), "waits");
  let_go_ = true;
  simulations_.make_room("", all, Progress());  // returns once it is freed
  EXPECT_EQ(wanted(all), "goes on");
}

TEST_F(Room, WhatGivesWayIsWaitedFor) {
  taken(700);
  EXPECT_EQ(wanted(301), "waits");
  EXPECT_TRUE(simulations_.all().empty());
}

TEST_F(Room, WhatIsHeldByOneThatGoesOnFromItIsNotWaitedFor) {
  const auto held = simulations_.find(taken(700));
  simulations_.remove(held->view().id);
  EXPECT_EQ(wanted(all), "goes on");
}

TEST_F(Room, MoreThanThereIsIsRefused) {
  EXPECT_EQ(wanted(all + 1), "refused");
}

}  // namespace
}  // namespace isochor
