#include "server/job_queue/numbered_id.h"

#include <gmock/gmock.h>

#include <set>

namespace isochor {
namespace {

TEST(NumberedId, OnlyThoseGivenOutWereIssued) {
  EXPECT_TRUE(was_issued("s1", 3));
  EXPECT_TRUE(was_issued("s2", 3));
  for (const char* id : {"s3", "s0", "s01", "s", "", "s1x", "s-1", "s99999999999999999999"})
    EXPECT_FALSE(was_issued(id, 3)) << id;
}

TEST(NumberedId, StandByAge) {
  const std::set<std::string, ByAge> ids{"s10", "s9", "s100", "s2", "s1"};
  EXPECT_THAT(ids, testing::ElementsAre("s1", "s2", "s9", "s10", "s100"));
}

}  // namespace
}  // namespace isochor
