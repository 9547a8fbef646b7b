#include "server/job_queue/worker_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <future>

namespace isochor {
namespace {

TEST(WorkerPool, ItsThreadsGiveWayToTheOneThatMadeThem) {
  std::promise<int> level;
  WorkerPool pool(1);
  pool.submit([&] { level.set_value(getpriority(PRIO_PROCESS, 0)); });
  constexpr int lowest = 19;
  EXPECT_GE(level.get_future().get(), std::min(lowest, getpriority(PRIO_PROCESS, 0) + 1));
}

TEST(WorkerPool, TakesManyAtOnceInTheirOrderAndTellsItsRoom) {
  std::promise<void> reached, let_go, done;
  WorkerPool pool(1, 3);
  pool.submit([&] {
    reached.set_value();
    let_go.get_future().wait();
  });
  reached.get_future().wait();
  EXPECT_EQ(pool.room(), 3U);
  std::vector<int> order;
  std::vector<WorkerPool::Task> tasks;
  for (int i = 0; i < 2; ++i) tasks.emplace_back([&order, i] { order.push_back(i); });
  tasks.emplace_back([&] { done.set_value(); });
  pool.submit(tasks);
  EXPECT_TRUE(tasks.empty());
  EXPECT_EQ(pool.room(), 0U);
  EXPECT_FALSE(pool.submit([] {}));
  let_go.set_value();
  done.get_future().wait();
  EXPECT_EQ(order, (std::vector{0, 1}));
  EXPECT_EQ(pool.room(), 3U);
}

}  // namespace
}  // namespace isochor
