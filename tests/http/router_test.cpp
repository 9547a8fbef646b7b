#include "server/http/router.h"

#include <gtest/gtest.h>

#include <array>

namespace isochor {
namespace {

Route route(std::string_view method, std::string_view pattern) {
  Route made;
  made.method = method;
  made.pattern = pattern;
  return made;
}
const std::array routes{route("GET", "/a/{id}/b"), route("POST", "/a/{id}/b"), route("DELETE", "/a")};

const RouteMatch* match(const std::variant<RouteMatch, NoRoute>& found) {
  return std::get_if<RouteMatch>(&found);
}

TEST(Router, FindsByMethodAndPath) {
  const auto found = find_route(routes, "POST", "/a/7/b");
  ASSERT_TRUE(match(found));
  EXPECT_EQ(match(found)->route, &routes[1]);
  EXPECT_EQ(match(found)->segments, (Fields{{"id", "7"}}));
  EXPECT_EQ(match(find_route(routes, "HEAD", "/a/7/b"))->route, &routes[0]);
}

TEST(Router, ASegmentIsDecodedAfterThePathWasCut) {
  const auto found = find_route(routes, "GET", "/a/..%2F..%2Fetc/b");
  ASSERT_TRUE(match(found));
  EXPECT_EQ(match(found)->segments[0].second, "../../etc");
}

TEST(Router, UnknownPathsAndMethods) {
  for (const char* path :
       {"/", "", "/a/", "/a//b", "/a/7", "/a/7/b/", "/a/7/b/c", "/A/7/b", "/a/7/%62", "a/7/b", "/../a"}) {
    const auto found = find_route(routes, "GET", path);
    ASSERT_FALSE(match(found)) << path;
    EXPECT_EQ(std::get<NoRoute>(found).refusal.status, 404) << path;
  }
  const auto found = find_route(routes, "PATCH", "/a/7/b");
  EXPECT_EQ(std::get<NoRoute>(found).refusal.status, 405);
  EXPECT_EQ(std::get<NoRoute>(found).allowed, "GET, HEAD, POST");
}

}  // namespace
}  // namespace isochor
