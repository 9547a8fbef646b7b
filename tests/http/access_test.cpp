#include "server/http/access.h"

#include <gtest/gtest.h>

namespace isochor {
namespace {

const AccessPolicy policy = loopback_policy(8080, "secret");

Head head(std::vector<std::pair<std::string, std::string_view>> fields) {
  Head made;
  made.method = "GET";
  made.fields = std::move(fields);
  return made;
}

int status(const std::optional<Refusal>& refusal) {
  return refusal ? refusal->status : 200;
}

int host_status(const std::string& host) {
  return status(check_origin(head({{"host", host}}), policy));
}

TEST(Access, TheThreeNamesOfLoopbackWithThePort) {
  for (const char* host :
       {"127.0.0.1:8080", "localhost:8080", "[::1]:8080", "LOCALHOST:8080", "LocalHost:8080"})
    EXPECT_EQ(host_status(host), 200) << host;
}

/// Of anything but loopback with its port.
const std::vector<std::string> other_hosts{"",
                                           "127.0.0.1",
                                           "localhost",
                                           "[::1]",
                                           "localhost:80",
                                           "localhost:8081",
                                           "localhost:08080",
                                           "localhost:8080 ",
                                           " localhost:8080",
                                           "LOCALHOST:8081",
                                           "LOCALHOST.EVIL.EXAMPLE:8080",
                                           "l\u00f6calhost:8080",
                                           "loca\u017fhost:8080",
                                           "localhost.:8080",
                                           "evil.example:8080",
                                           "localhost.evil.example:8080",
                                           "evil.example#localhost:8080",
                                           "user@localhost:8080",
                                           "localhost:8080@evil.example",
                                           "127.0.0.2:8080",
                                           "127.1:8080",
                                           "0x7f000001:8080",
                                           "2130706433:8080",
                                           "0177.0.0.1:8080",
                                           "0.0.0.0:8080",
                                           "::1:8080",
                                           "[::ffff:127.0.0.1]:8080",
                                           "[0:0:0:0:0:0:0:1]:8080",
                                           "localhost:8080,evil.example",
                                           "127.0.0.1:8080.evil.example",
                                           "http://localhost:8080",
                                           "localhost:8080/",
                                           "127.0.0.1%00:8080"};

TEST(Access, EveryOtherSpellingOfHostIsRefused) {
  for (const std::string& host : other_hosts) EXPECT_EQ(host_status(host), 421) << host;
}

TEST(Access, AnAbsoluteTargetIsJudgedByItsOwnAuthority) {
  const auto with = [](const std::string& authority, const std::string& host, const std::string& origin) {
    Head made = head({{"host", host}, {"origin", origin}});
    made.authority = authority;
    return status(check_origin(made, policy));
  };
  const std::string own = "127.0.0.1:8080", also_own = "localhost:8080";
  EXPECT_EQ(with(own, own, "http://" + own), 200);
  EXPECT_EQ(with(own, also_own, "http://" + own), 200);
  EXPECT_EQ(with(own, also_own, "http://" + also_own), 403);
  for (const std::string& other : other_hosts) {
    if (!other.empty()) {  // else it is no absolute target
      EXPECT_EQ(with(other, own, "http://" + own), 421) << other;
    }
    EXPECT_EQ(with(own, other, "http://" + own), 421) << other;
  }
  Head hostless = head({});
  hostless.authority = own;
  EXPECT_EQ(status(check_origin(hostless, policy)), 400);
}

TEST(Access, ExactlyOneHost) {
  EXPECT_EQ(status(check_origin(head({}), policy)), 400);
  EXPECT_EQ(status(check_origin(head({{"host", "localhost:8080"}, {"host", "localhost:8080"}}), policy)),
            400);
  EXPECT_EQ(status(check_origin(head({{"host", "localhost:8080"}, {"host", "evil.example"}}), policy)), 400);
}

TEST(Access, PortEightyMayGoUnsaid) {
  const AccessPolicy plain = loopback_policy(80, "secret");
  EXPECT_FALSE(check_origin(head({{"host", "localhost"}}), plain));
  EXPECT_FALSE(check_origin(head({{"host", "localhost:80"}}), plain));
  EXPECT_TRUE(check_origin(head({{"host", "localhost:8080"}}), plain));
}

TEST(Access, OriginIsOursOrAbsent) {
  const auto with = [](const std::string& origin) {
    return status(check_origin(head({{"host", "127.0.0.1:8080"}, {"origin", origin}}), policy));
  };
  EXPECT_EQ(with("http://127.0.0.1:8080"), 200);
  EXPECT_EQ(
      status(check_origin(head({{"host", "LOCALHOST:8080"}, {"origin", "http://localhost:8080"}}), policy)),
      200);
  for (const char* origin : {"null", "", "http://evil.example", "https://127.0.0.1:8080", "http://127.0.0.1",
                             "http://127.0.0.1:8081", "http://localhost:8080", "http://127.0.0.1:8080/",
                             "http://127.0.0.1:8080.evil.example", "HTTP://127.0.0.1:8080", "file://"})
    EXPECT_EQ(with(origin), 403) << origin;
  EXPECT_EQ(status(check_origin(head({{"host", "127.0.0.1:8080"},
                                      {"origin", "http://127.0.0.1:8080"},
                                      {"origin", "http://evil.example"}}),
                                policy)),
            403);
}

TEST(Access, OnlyOurOwnPageOrThePersonCausesRequests) {
  const auto with = [](const std::string& site) {
    return status(check_origin(head({{"host", "127.0.0.1:8080"}, {"sec-fetch-site", site}}), policy));
  };
  EXPECT_EQ(with("same-origin"), 200);
  EXPECT_EQ(with("none"), 200);
  for (const char* site : {"cross-site", "same-site", "", "Same-Origin", "none, none"})
    EXPECT_EQ(with(site), 403) << site;
}

TEST(Access, TheTokenOfThisLaunch) {
  const auto with = [](const std::string& value) {
    return status(check_token(head({{"authorization", value}}), policy));
  };
  for (const char* value : {"Bearer secret", "bearer secret"}) EXPECT_EQ(with(value), 200) << value;
  for (const char* value : {"", "secret", "Bearer", "Bearer ", "Bearer secre", "Bearer secrets",
                            "Bearer Secret", "Bearer\tsecret", "Basic secret", "Bearer  secret"})
    EXPECT_EQ(with(value), 401) << value;
  EXPECT_EQ(status(check_token(head({}), policy)), 401);
  EXPECT_EQ(
      status(check_token(head({{"authorization", "Bearer secret"}, {"authorization", "Bearer x"}}), policy)),
      401);
}

TEST(Access, ANameOfOnesOwnIsAnsweredToo) {
  const AccessPolicy own = loopback_policy(8080, "secret", "Meshes.Test");
  EXPECT_FALSE(check_origin(head({{"host", "meshes.test:8080"}}), own));
  EXPECT_FALSE(check_origin(head({{"host", "127.0.0.1:8080"}}), own));
  EXPECT_TRUE(check_origin(head({{"host", "meshes.test:8081"}}), own));
  EXPECT_TRUE(check_origin(head({{"host", "meshes.test:8080"}}), policy));
}

TEST(Access, TokensAreLongAndNeverTheSame) {
  const std::string a = make_token(), b = make_token();
  EXPECT_EQ(a.size(), 64U);
  EXPECT_NE(a, b);
}

TEST(Access, AnotherAddressTakesAnyOneHostButItsOriginMustAgree) {
  const AccessPolicy open{.hosts = {}, .token = "secret", .token_for_reading = true};
  EXPECT_FALSE(check_origin(head({{"host", "box:8080"}}), open));
  EXPECT_FALSE(check_origin(head({{"host", "box:8080"}, {"origin", "http://box:8080"}}), open));
  EXPECT_TRUE(check_origin(head({{"host", "box:8080"}, {"origin", "http://evil.example"}}), open));
  EXPECT_TRUE(check_origin(head({{"host", ""}}), open));
}

TEST(Access, BehindAProxyThatEndsTlsTheOriginIsHttps) {
  const AccessPolicy open{.hosts = {}, .token = "secret", .token_for_reading = true};
  EXPECT_FALSE(check_origin(head({{"host", "box.example"}, {"origin", "https://box.example"}}), open));
  EXPECT_TRUE(check_origin(head({{"host", "box.example"}, {"origin", "https://evil.example"}}), open));
  EXPECT_TRUE(check_origin(head({{"host", "localhost:8080"}, {"origin", "https://localhost:8080"}}), policy));
}

TEST(Access, BrowsersTrustLoopbackAndTls) {
  const auto trusted = [](Fields headers) {
    Request request;
    request.headers = std::move(headers);
    return has_trustworthy_origin(request);
  };
  EXPECT_TRUE(trusted({{"host", "127.0.0.1:8080"}}));
  EXPECT_TRUE(trusted({{"host", "localhost"}}));
  EXPECT_TRUE(trusted({{"host", "LOCALHOST:8080"}}));
  EXPECT_TRUE(trusted({{"host", "[::1]:8080"}}));
  EXPECT_TRUE(trusted({{"host", "box.example"}, {"x-forwarded-proto", "https"}}));
  EXPECT_FALSE(trusted({{"host", "box.example"}, {"x-forwarded-proto", "http"}}));
  EXPECT_FALSE(trusted({{"host", "box.example:8080"}}));
  EXPECT_FALSE(trusted({{"host", "192.168.1.2:8080"}}));
  EXPECT_FALSE(trusted({}));
}

}  // namespace
}  // namespace isochor
