#include "server/job_queue/job_queue.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/messages/problem_messages.h"

namespace isochor {
namespace {

/// Waits, without a clock of its own, until a job has ended.
class Queue : public testing::Test {
 protected:
  JobView wait(const std::string& id) {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return jobs_.find(id)->ended(); });
    return *jobs_.find(id);
  }
  static std::string until_cancelled(Progress& progress) {
    for (;;) {
      progress.throw_if_cancelled();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void wait_until_running(const std::string& id) {
    while (jobs_.find(id)->status == JobStatus::queued) std::this_thread::yield();
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  JobQueue jobs_{1, [this] {
                   std::lock_guard lock(mutex_);
                   ended_.notify_all();
                 }};
};

TEST_F(Queue, AJobEndsWithItsResult) {
  const JobView job = wait(jobs_
                               .submit("sum",
                                       [](Progress& progress) {
                                         progress.report("adding", 0.5);
                                         return std::string("{\"sum\":3}");
                                       })
                               .id);
  EXPECT_EQ(job.status, JobStatus::done);
  EXPECT_EQ(job.result, "{\"sum\":3}");
  EXPECT_EQ(job.fraction, 1.0);
  EXPECT_EQ(job.phase, "adding");
}

TEST_F(Queue, ProgressAndTheTimeLeftAreSeenOnTheWay) {
  std::atomic<bool> reported{false}, go{false};
  const std::string id = jobs_
                             .submit("slow",
                                     [&](Progress& progress) {
                                       progress.report("half", 0.5);
                                       reported = true;
                                       while (!go) std::this_thread::yield();
                                       return std::string("{}");
                                     })
                             .id;
  while (!reported) std::this_thread::yield();
  const JobView job = *jobs_.find(id);
  EXPECT_EQ(job.status, JobStatus::running);
  EXPECT_EQ(job.fraction, 0.5);
  EXPECT_TRUE(job.eta_s.has_value());
  go = true;
  wait(id);
}

TEST_F(Queue, ARunningJobIsCancelled) {
  const std::string id = jobs_.submit("endless", until_cancelled).id;
  wait_until_running(id);
  EXPECT_TRUE(jobs_.under_way(id));
  EXPECT_TRUE(jobs_.cancel(id));
  EXPECT_FALSE(jobs_.under_way(id));
  const JobView job = wait(id);
  EXPECT_EQ(job.status, JobStatus::cancelled);
  EXPECT_NE(job.problem.find("cancelled"), std::string::npos);
}

TEST_F(Queue, ACancelledJobHasEndedThoughItStillFreesWhatItHolds) {
  std::atomic<bool> freed{false}, noticed{false};
  const auto work = [&](Progress& progress) {
    try {
      return until_cancelled(progress);
    } catch (const Error&) {
      noticed = true;
      while (!freed) std::this_thread::yield();
      throw;
    }
  };
  const std::string id = jobs_.submit("large", work).id;
  wait_until_running(id);
  jobs_.cancel(id);
  EXPECT_EQ(jobs_.find(id)->status, JobStatus::cancelled);
  const std::string next =
      jobs_.submit("next", [&](Progress&) { return std::string(freed ? "{}" : "beside it"); }).id;
  while (!noticed) std::this_thread::yield();
  EXPECT_EQ(jobs_.find(next)->status, JobStatus::queued);
  freed = true;
  EXPECT_EQ(wait(next).result, "{}");
  EXPECT_EQ(jobs_.find(id)->status, JobStatus::cancelled);
}

TEST_F(Queue, AWaitingJobIsCancelledWithoutRunning) {
  const std::string first = jobs_.submit("endless", until_cancelled).id;
  std::atomic<bool> ran{false};
  const std::string second = jobs_
                                 .submit("never",
                                         [&](Progress&) {
                                           ran = true;
                                           return std::string("{}");
                                         })
                                 .id;
  jobs_.cancel(second);
  EXPECT_EQ(jobs_.find(second)->status, JobStatus::cancelled);
  jobs_.cancel(first);
  wait(first);
  wait(jobs_.submit("after", [](Progress&) { return std::string("{}"); }).id);
  EXPECT_FALSE(ran);
}

TEST_F(Queue, WhatAJobThrowsIsItsProblem) {
  const JobView failed =
      wait(jobs_
               .submit("bad",
                       [](Progress&) -> std::string {
                         throw Error(ErrorCode::empty_result, "nothing inside", "try p_in 0.93");
                       })
               .id);
  EXPECT_EQ(failed.status, JobStatus::failed);
  EXPECT_NE(failed.problem.find("try p_in 0.93"), std::string::npos);
  EXPECT_NE(wait(jobs_.submit("bad", [](Progress&) -> std::string { throw std::bad_alloc(); }).id)
                .problem.find("over_budget"),
            std::string::npos);
}

TEST_F(Queue, TheLineIsBounded) {
  const std::string first = jobs_.submit("endless", until_cancelled).id;
  wait_until_running(first);
  std::vector<std::string> waiting;
  try {
    for (int i = 0; i < 1000; ++i) waiting.push_back(jobs_.submit("more", until_cancelled).id);
  } catch (const RefusalException& full) {
    EXPECT_EQ(full.refusal.status, 503);
  }
  EXPECT_LT(waiting.size(), 1000U);
  for (const std::string& id : waiting) jobs_.cancel(id);
}

TEST_F(Queue, TheOldestEndedAreForgotten) {
  const std::string first = jobs_.add_done("done", "{}").id;
  for (int i = 0; i < 400; ++i) jobs_.add_done("done", "{}");
  EXPECT_FALSE(jobs_.find(first));
  const std::vector<JobView> kept = jobs_.all();
  EXPECT_LT(kept.size(), 300U);
  EXPECT_EQ(kept.back().id, "j401") << "by age";
}

TEST_F(Queue, TheQueueGoesWithItsJobs) {
  JobQueue local(2, [] {});
  local.submit("endless", until_cancelled);
  local.submit("endless", until_cancelled);
  local.submit("endless", until_cancelled);
}

}  // namespace
}  // namespace isochor
