#include "core/parallel/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/parallel/cancel_scope.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/cancellable_sort.h"
#include "core/parallel/thread_trial.h"

namespace isochor {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};

TEST_P(Parallel, VisitsEveryIndexOnce) {
  for (const Work work : {Work::uneven, Work::alike})
    for (const std::int64_t count : {0, 1, 7, 64, 1000}) {
      std::vector<std::atomic<int>> visits(count);
      const auto visit = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i) ++visits[i];
      };
      parallel_for(count, 13, visit, work);
      for (const auto& times : visits) EXPECT_EQ(times.load(), 1);
    }
}

TEST_P(Parallel, SumsKeptAChunkAreTheSameBits) {
  const std::int64_t count = 10007, grain = 100;
  std::vector<double> partial((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) partial[begin / grain] += 1.0 / (1.0 + static_cast<double>(i));
  });
  set_thread_count(1);
  std::vector<double> serial(partial.size());
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) serial[begin / grain] += 1.0 / (1.0 + static_cast<double>(i));
  });
  EXPECT_EQ(std::accumulate(partial.begin(), partial.end(), 0.0),
            std::accumulate(serial.begin(), serial.end(), 0.0));
}

TEST_P(Parallel, NestsAndRethrows) {
  std::atomic<int> total{0};
  parallel_for(10, 1, [&](std::int64_t, std::int64_t) {
    parallel_for(10, 1, [&](std::int64_t, std::int64_t) { ++total; });
  });
  EXPECT_EQ(total.load(), 100);
  EXPECT_THROW(parallel_for(10, 1,
                            [](std::int64_t begin, std::int64_t) {
                              if (begin == 5) throw std::runtime_error("five");
                            }),
               std::runtime_error);
  parallel_for(10, 1, [&](std::int64_t, std::int64_t) { ++total; });
  EXPECT_EQ(total.load(), 110);
}

TEST_P(Parallel, ManyShortRegions) {
  std::atomic<std::int64_t> total{0};
  for (int region = 0; region < 20000; ++region)
    parallel_for(4, 1, [&](std::int64_t begin, std::int64_t) { total += begin; });
  EXPECT_EQ(total.load(), 20000 * 6);
}

TEST_P(Parallel, EndsWhenTheScopeOfItsThreadIsCancelled) {
  std::atomic<bool> cancel{false};
  std::atomic<int> visits{0};
  const auto count_until = [&](int last) {
    parallel_for(1000, 1, [&](std::int64_t, std::int64_t) { cancel = ++visits >= last; });
  };
  const Progress progress({}, &cancel), never;
  {
    const CancelScope scope(progress);
    count_until(2000);
    EXPECT_EQ(visits.load(), 1000);
    EXPECT_THROW(count_until(1100), Error);
    EXPECT_LT(visits.load(), 1200);
    {
      const CancelScope inner(never);
      EXPECT_NO_THROW(throw_if_scope_cancelled());
    }
    EXPECT_THROW(throw_if_scope_cancelled(), Error);
  }
  visits = 0;
  count_until(100);  // and nobody else's
  EXPECT_EQ(visits.load(), 1000);
}

TEST(CancellableRange, HasTheSameElementsAndEndsWithItsScope) {
  const std::vector<int> values(100000, 1);
  std::int64_t seen = 0;
  for (const int value : cancellable(values)) seen += value;
  EXPECT_EQ(seen, 100000);
  std::atomic<bool> cancel{false};
  const Progress progress({}, &cancel);
  const CancelScope scope(progress);
  const auto stop_at_half = [&] {
    seen = 0;
    for (const int value : cancellable(values)) {
      seen += value;
      if (seen == 50000) cancel = true;
    }
  };
  EXPECT_THROW(stop_at_half(), Error);
  EXPECT_LT(seen, 60000);
}

TEST_P(Parallel, RunsOnOneThreadWithinAnAloneScope) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> elsewhere{0}, visits{0};
  const auto visit = [&](std::int64_t, std::int64_t) {
    ++visits;
    elsewhere += std::this_thread::get_id() != caller;
  };
  {
    const AloneScope outer(true), inner(false);
    for (int region = 0; region < 200; ++region) parallel_for(64, 1, visit);
  }
  EXPECT_EQ(visits.load(), 200 * 64);
  EXPECT_EQ(elsewhere.load(), 0);
}

TEST(ThreadTrial, TakesWhatIsSoonerAndAsksAgain) {
  ThreadTrial trial;
  for (const double all_threads : {2.0, 0.5}) {
    int alone = 0;
    for (int piece = 0; piece < ThreadTrial::trials + ThreadTrial::pieces_between; ++piece) {
      const bool by_itself = trial.alone();
      alone += by_itself;
      const double late = piece % 3 == 0 ? 10.0 : 0.0;  // something else had the core
      trial.took(3.0 * (late + (by_itself ? 1.0 : all_threads)), 3.0);
      trial.took(100.0, 0.0);  // nothing was to be done
    }
    EXPECT_EQ(alone, ThreadTrial::trials / 2 + (all_threads > 1.0 ? ThreadTrial::pieces_between : 0));
  }
}

TEST(CancellableRange, ResizesAndCopiesLikeAVector) {
  std::vector<double> values;
  cancellable_resize(values, std::size_t{3} << 20);
  EXPECT_EQ(values, std::vector<double>(std::size_t{3} << 20));
  std::iota(values.begin(), values.end(), 0.0);
  EXPECT_EQ(cancellable_copy(values), values);
  EXPECT_EQ(cancellable_copy(std::vector<int>()), std::vector<int>());
  std::atomic<bool> cancel{true};
  const Progress progress({}, &cancel);
  const CancelScope scope(progress);
  EXPECT_THROW(cancellable_copy(values), Error);
  EXPECT_THROW(cancellable_resize(values, values.size() + 1), Error);
}

TEST(CancellableSort, SortsAndEndsWithItsScope) {
  std::vector<std::uint32_t> values(1 << 18);
  std::uint32_t random = 1;
  for (std::uint32_t& value : values) value = random = random * 1664525U + 1013904223U;
  std::vector<std::uint32_t> sorted = values;
  std::ranges::sort(sorted);
  const std::atomic<bool> cancel{true};
  const Progress progress({}, &cancel);
  {
    const CancelScope scope(progress);
    std::vector<std::uint32_t> given_up = values;
    EXPECT_THROW(cancellable_sort(given_up), Error);
  }
  cancellable_sort(values);
  EXPECT_EQ(values, sorted);
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 3, 8));

}  // namespace
}  // namespace isochor
