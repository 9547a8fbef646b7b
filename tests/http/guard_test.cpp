#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/support/running_server.h"

namespace isochor {
namespace {

using test::HttpClient;
using test::HttpResponse;
using test::RawSocket;

class Guard : public testing::Test {
 protected:
  explicit Guard(const FrontLimits& limits = {}) : running_({}, limits) {}
  std::string host_line() const { return "Host: " + client_.host() + "\r\n"; }
  std::string token_line() const { return "Authorization: Bearer " + client_.token() + "\r\n"; }
  std::size_t mesh_count() const { return client_.get("/api/v1/meshes").json()["meshes"].size(); }
  /// The only thing that a smuggled or forged request would change.
  void expect_nothing_changed() const { EXPECT_EQ(mesh_count(), before_); }

  test::RunningServer running_;
  HttpClient client_ = running_.client();
  std::size_t before_ = [this] {
    client_.send("POST", "/api/v1/meshes?sample=tree");  // as the server does by itself at the start
    return mesh_count();
  }();
};

const std::string smuggled_path = "/api/v1/meshes?sample=cube";

TEST_F(Guard, ARefusedBodyIsNeverTheNextRequest) {
  const std::string inner =
      "POST " + smuggled_path + " HTTP/1.1\r\n" + host_line() + token_line() + "Content-Length: 0\r\n\r\n";
  const std::string evil = "POST /api/v1/meshes HTTP/1.1\r\nHost: evil.example\r\nContent-Length: " +
                           std::to_string(inner.size()) + "\r\n\r\n" + inner;
  EXPECT_EQ(client_.exchange(evil).status, 421);
  expect_nothing_changed();
}

TEST_F(Guard, AGetWithABodyIsNeverTwoRequests) {
  const std::string inner =
      "POST " + smuggled_path + " HTTP/1.1\r\n" + host_line() + token_line() + "Content-Length: 0\r\n\r\n";
  EXPECT_EQ(client_
                .exchange("GET /api/v1/health HTTP/1.1\r\n" + host_line() +
                          "Content-Length: " + std::to_string(inner.size()) + "\r\n\r\n" + inner)
                .status,
            400);
  // One request a connection: what follows is not read, declared or not.
  EXPECT_EQ(client_.exchange("GET /api/v1/health HTTP/1.1\r\n" + host_line() + "\r\n" + inner).status, 200);
  expect_nothing_changed();
}

TEST_F(Guard, AChunkedBodyIsNeverTwoRequests) {
  const std::string inner =
      "POST " + smuggled_path + " HTTP/1.1\r\n" + host_line() + token_line() + "Content-Length: 0\r\n\r\n";
  EXPECT_EQ(client_
                .exchange("POST /api/v1/meshes HTTP/1.1\r\n" + host_line() + token_line() +
                          "Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n0\r\n\r\n" + inner)
                .status,
            411);
  expect_nothing_changed();
}

TEST_F(Guard, ChangesNeedTheToken) {
  for (const std::string token : {"", "Authorization: Bearer wrong\r\n"}) {
    const HttpResponse response = client_.exchange("POST " + smuggled_path + " HTTP/1.1\r\n" + host_line() +
                                                   token + "Content-Length: 0\r\n\r\n");
    EXPECT_EQ(response.status, 401);
    EXPECT_EQ(response.header("www-authenticate"), "Bearer");
  }
  expect_nothing_changed();
  EXPECT_EQ(client_.send("POST", smuggled_path).status, 201);
}

TEST_F(Guard, OtherSitesAreRefusedAndGetNoPermission) {
  const HttpResponse preflight = client_.exchange("OPTIONS " + smuggled_path + " HTTP/1.1\r\n" + host_line() +
                                                  "Origin: http://evil.example\r\n\r\n");
  EXPECT_EQ(preflight.status, 403);
  EXPECT_EQ(preflight.header("access-control-allow-origin"), "");
  EXPECT_EQ(client_.get("/api/v1/health", {{"Sec-Fetch-Site", "cross-site"}}).status, 403);
  EXPECT_EQ(client_.get("/", {{"Sec-Fetch-Site", "cross-site"}, {"Sec-Fetch-Mode", "navigate"}}).status, 403);
  EXPECT_EQ(client_.get("/", {{"Sec-Fetch-Site", "none"}, {"Sec-Fetch-Mode", "navigate"}}).status, 200);
}

TEST_F(Guard, NoPathLeavesTheTableOfAssets) {
  for (const std::string path :
       {"/../CMakeLists.txt", "/..%2fCMakeLists.txt", "/%2e%2e/CMakeLists.txt", "/./index.html",
        "//index.html", "/index.html/", "/node_modules/three/package.json", "/package.json", "/etc/passwd",
        "/styles/../index.html", "/index.html%20", "/INDEX.HTML",
        "/api/v1/samples/meshes/..%2f..%2fCMakeLists.txt"})
    EXPECT_EQ(client_.get(path).status, 404) << path;
  EXPECT_EQ(client_.get("/index.html%00.js").status, 400);
  EXPECT_EQ(client_.get("/index.html").status, 200);
}

TEST_F(Guard, EveryAnswerCarriesThePolicy) {
  for (const std::string path : {"/", "/api/v1/health", "/nothing", "/index.html%00"}) {
    const HttpResponse response = client_.get(path);
    EXPECT_EQ(response.header("content-security-policy").find("default-src 'none'; script-src 'self';"), 0U)
        << path;
    EXPECT_NE(response.header("content-security-policy").find("frame-ancestors 'none'"), std::string::npos)
        << path;
    EXPECT_EQ(response.header("x-content-type-options"), "nosniff") << path;
    EXPECT_EQ(response.headers.count("access-control-allow-origin"), 0U) << path;
  }
}

TEST_F(Guard, OnlyThePageHoldsTheToken) {
  EXPECT_NE(client_.get("/").body.find(client_.token()), std::string::npos);
  EXPECT_EQ(client_.get("/").header("cache-control"), "no-store");
  for (const std::string path : {"/main.js", "/api/v1/openapi.json", "/api/v1/docs", "/api/v1/version"})
    EXPECT_EQ(client_.get(path).body.find(client_.token()), std::string::npos) << path;
}

TEST_F(Guard, BodiesAreBoundedBeforeTheyAreRead) {
  const std::string head = "POST /api/v1/models HTTP/1.1\r\n" + host_line() + token_line();
  EXPECT_EQ(
      client_.exchange(head + "Content-Type: application/json\r\nContent-Length: 999999999\r\n\r\n").status,
      413);
  EXPECT_EQ(client_.exchange(head + "Content-Type: application/json\r\n\r\n").status, 411);
  for (const char* other : {"text/plain", "application/jsonx", "application/json-seq"})
    EXPECT_EQ(client_.exchange(head + "Content-Type: " + other + "\r\nContent-Length: 2\r\n\r\n{}").status,
              415)
        << other;
  for (const char* json : {"application/json", "Application/JSON", "application/json ; charset=utf-8"})
    EXPECT_EQ(client_.exchange(head + "Content-Type: " + json + "\r\nContent-Length: 2\r\n\r\n{}").status,
              422)
        << json;
  EXPECT_EQ(client_.exchange(head + "Content-Encoding: gzip\r\nContent-Length: 2\r\n\r\n{}").status, 415);
}

/// Takes two large bodies at once, of a megabyte together.
class SmallGuard : public Guard {
 protected:
  SmallGuard() : Guard(limits()) {}
  static FrontLimits limits() {
    FrontLimits limits;
    limits.bodies = {.connections = 2, .bytes = 1 << 20};
    return limits;
  }
  /// One that has sent the first part of a body of a megabyte.
  RawSocket sender(std::size_t sent) const {
    RawSocket socket(client_.port());
    socket.send("POST /api/v1/meshes?name=a.obj HTTP/1.1\r\n" + host_line() + token_line() +
                "Content-Length: 1048576\r\n\r\n" + std::string(sent, '#'));
    return socket;
  }
  static void expect_gave_way(RawSocket& socket) {
    const HttpResponse answer = test::parse_response(socket.receive_all());
    EXPECT_EQ(answer.status, 503);
    EXPECT_EQ(answer.json()["code"], "busy");
  }
};

TEST_F(SmallGuard, OfBodiesThatAreTooManyTheOldestGiveWay) {
  RawSocket first = sender(1000), second = sender(1000), third = sender(1000);
  expect_gave_way(first);
  EXPECT_EQ(
      client_.send("POST", "/api/v1/meshes?name=strip.obj", std::string(10000, '#') + "\nv 0 0 0\n").status,
      422);
  expect_gave_way(second);
}

TEST_F(SmallGuard, OfBodiesThatAreTooLargeTogetherTheOldestGivesWay) {
  RawSocket first = sender(700000), second = sender(700000);
  expect_gave_way(first);
  second.send(std::string(1048576 - 700000, '#'));
  EXPECT_EQ(test::parse_response(second.receive_all()).status, 422);
}

TEST_F(Guard, ALargeBodyThatNoDiskTakesIsTold) {
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/nowhere", 1);
  const std::string large = std::string(100000, '#') + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const HttpResponse refused = client_.send("POST", "/api/v1/meshes?name=a.obj", large);
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  EXPECT_EQ(refused.status, 507);
  EXPECT_NE(refused.json()["hint"].get<std::string>().find("TMPDIR"), std::string::npos);
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?name=a.obj", large).status, 201);
}

/// A server that waits for a second, not a minute, for what a peer sends.
class ImpatientGuard : public Guard {
 protected:
  ImpatientGuard() : Guard(limits()) {}
  static FrontLimits limits() {
    FrontLimits limits;
    limits.connection.head = limits.connection.body = std::chrono::seconds(1);
    return limits;
  }
};

TEST_F(ImpatientGuard, SlowHeadsAndBodiesAreDropped) {
  RawSocket silent(client_.port()), slow_head(client_.port());
  slow_head.send("GET /api/v1/health HTTP/1.1\r\nHost");
  RawSocket slow_body(client_.port());
  slow_body.send("POST /api/v1/meshes?name=a.obj HTTP/1.1\r\n" + host_line() + token_line() +
                 "Content-Length: 100\r\n\r\nv 0 0 0\n");
  EXPECT_EQ(silent.receive_all(), "");
  EXPECT_EQ(test::parse_response(slow_head.receive_all()).status, 408);
  EXPECT_EQ(test::parse_response(slow_body.receive_all()).status, 408);
}

/// A strip of triangles, so many that no kernel buffer holds its geometry.
std::string long_strip(int triangles) {
  std::string obj = "v 0 0 0\nv 0 1 0\n";
  for (int i = 1; i <= triangles; ++i)
    obj += "v " + std::to_string(i) + " " + std::to_string(i % 2) + " 0\nf -1 -2 -3\n";
  return obj;
}

/// One that waits a moment, not half a minute, for a peer to take what it asked for.
class HastyGuard : public Guard {
 protected:
  HastyGuard() : Guard(limits()) {}
  static FrontLimits limits() {
    FrontLimits limits;
    limits.connection.stalled_write = std::chrono::milliseconds(300);
    return limits;
  }
};

TEST_F(HastyGuard, AReaderThatTakesNothingIsDropped) {
  const std::string id =
      client_.send("POST", "/api/v1/meshes?name=strip.obj", long_strip(200000)).json()["id"];
  const std::string path = "/api/v1/meshes/" + id + "/geometry";
  const std::size_t whole = std::stoul(client_.send("HEAD", path).header("content-length"));
  // What the kernel's buffers hold still comes; the rest was given up after the time for a stalled write. A
  // server on a busy machine is given more of it.
  std::size_t got = whole;
  for (auto wait = std::chrono::milliseconds(1500); got == whole && wait < std::chrono::minutes(1);
       wait *= 2) {
    RawSocket reader(client_.port());
    reader.send(client_.request("GET", path, "", {}));
    std::this_thread::sleep_for(wait);
    got = test::parse_response(reader.receive_all()).body.size();
  }
  EXPECT_LT(got, whole);
}

TEST(Front, OfAnswersThatAreNotTakenTheOldestAreGivenUp) {
  FrontLimits limits;
  limits.unsent_files = 1 << 20;
  const test::RunningServer running({}, limits);
  const HttpClient client = running.client();
  const auto geometry = [&](int triangles) {
    return "/api/v1/meshes/" +
           client.send("POST", "/api/v1/meshes?name=strip.obj", long_strip(triangles))
               .json()["id"]
               .get<std::string>() +
           "/geometry";
  };
  const std::string first = geometry(200000), second = geometry(200001);
  const std::size_t whole = client.get(first).body.size();
  RawSocket oldest(client.port()), newest(client.port());
  oldest.send(client.request("GET", first, "", {}));
  EXPECT_EQ(oldest.receive(1), "H");
  newest.send(client.request("GET", second, "", {}));
  EXPECT_EQ(newest.receive(1), "H");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_LT(oldest.receive_all().size(), whole);
  EXPECT_GT(newest.receive_all().size(), whole);
}

TEST_F(Guard, AnAbsoluteTargetIsServedUnderOurOwnNamesOnly) {
  const auto with = [&](const std::string& method, const std::string& target, const std::string& host) {
    RawSocket socket(client_.port());
    socket.send(method + " " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + token_line() + "\r\n");
    return test::parse_response(socket.receive_all()).status;
  };
  const std::string port = ":" + std::to_string(client_.port());
  for (const std::string& name : {"127.0.0.1" + port, "localhost" + port, "[::1]" + port})
    EXPECT_EQ(with("GET", "http://" + name + "/api/v1/health", client_.host()), 200) << name;
  for (const std::string& name :
       {std::string("127.0.0.1"), "evil.example" + port, "localhost.evil.example" + port,
        "evil.example/@localhost" + port, std::string("127.0.0.1:1")}) {
    EXPECT_EQ(with("GET", "http://" + name + "/api/v1/health", client_.host()), 421) << name;
    EXPECT_EQ(with("POST", "http://" + name + smuggled_path, client_.host()), 421) << name;
  }
  EXPECT_EQ(with("POST", "http://" + client_.host() + smuggled_path, "evil.example" + port), 421);
  EXPECT_EQ(with("POST", "http://evil@" + client_.host() + smuggled_path, client_.host()), 400);
  expect_nothing_changed();
  EXPECT_EQ(with("POST", "http://" + client_.host() + smuggled_path, client_.host()), 201);
}

TEST_F(Guard, EndlessHeadsAreCutOff) {
  RawSocket line(client_.port()), headers(client_.port());
  std::size_t sent = 0;
  const std::string part(4096, 'a');
  line.send("GET /");
  while (sent < (std::size_t{64} << 20) && line.send(part)) sent += part.size();
  EXPECT_LT(sent, std::size_t{16} << 20);
  headers.send("GET / HTTP/1.1\r\n" + host_line());
  for (sent = 0; sent < (std::size_t{64} << 20) && headers.send("X-A: b\r\n");) sent += 8;
  EXPECT_LT(sent, std::size_t{16} << 20);
}

TEST_F(Guard, ALongHeaderHidesNothing) {
  const std::string line = "X-Long: " + std::string(10000, 'a') + "\r\n";
  const HttpResponse page = client_.get("/main.js");
  EXPECT_EQ(client_
                .exchange("GET /main.js HTTP/1.1\r\n" + host_line() + line +
                          "If-None-Match: " + page.header("etag") + "\r\n\r\n")
                .status,
            304);
  EXPECT_EQ(client_.exchange("GET /api/v1/health?none=1 HTTP/1.1\r\n" + host_line() + line + "\r\n").status,
            422);
}

TEST_F(Guard, AQueryIsDecodedOnce) {
  for (const std::string query : {"name=a%2Bb+c.obj", "name=a%2bb%20c.obj&", "&&name=a%2Bb+c.obj"}) {
    const HttpResponse made =
        client_.send("POST", "/api/v1/meshes?" + query, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(made.json()["name"], "a+b c.obj") << query;
  }
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?name=a.obj&name=b.obj", "v 0 0 0\n").status, 422);
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?name", "v 0 0 0\n").status, 415);
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?=a.obj", "v 0 0 0\n").status, 422);
}

TEST_F(Guard, ContinueIsSentForThoseWhoAsk) {
  RawSocket socket(client_.port());
  const std::string body = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  socket.send("POST /api/v1/meshes?name=a.obj HTTP/1.1\r\n" + host_line() + token_line() +
              "Expect: 100-continue\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n");
  EXPECT_EQ(socket.receive(25), "HTTP/1.1 100 Continue\r\n\r\n");
  socket.send(body);
  EXPECT_EQ(test::parse_response(socket.receive_all()).status, 201);
}

TEST_F(Guard, ASecondInstanceOnThePortIsTold) {
  EXPECT_THROW(Listener("127.0.0.1", client_.port()), PortInUse);
}

TEST_F(Guard, AnotherInterfaceNeedsAToken) {
  ServeOptions options;
  options.host = "0.0.0.0";
  options.port = 0;
  EXPECT_THROW(Server{options}, Error);
  options.token = "of-my-own";
  test::RunningServer open(options);
  const int port = open.server().port();
  const auto status = [&](const std::string& path, const std::string& fields) {
    RawSocket socket(port);
    socket.send("GET " + path + " HTTP/1.1\r\nHost: box:1\r\n" + fields + "\r\n");
    return test::parse_response(socket.receive_all());
  };
  EXPECT_EQ(status("/api/v1/meshes", "").status, 401);
  EXPECT_EQ(status("/api/v1/meshes", "Authorization: Bearer of-my-own\r\n").status, 200);
  EXPECT_EQ(status("/api/v1/health", "").status, 200);
  EXPECT_EQ(status("/", "").status, 200);
  EXPECT_EQ(status("/", "").body.find("of-my-own"), std::string::npos);
  // Over plain HTTP from elsewhere browsers ignore this header, and warn.
  EXPECT_EQ(status("/", "").headers.count("cross-origin-opener-policy"), 0U);
  EXPECT_EQ(status("/", "X-Forwarded-Proto: https\r\n").headers.count("cross-origin-opener-policy"), 1U);
  EXPECT_EQ(client_.get("/").headers.count("cross-origin-opener-policy"), 1U);
}

}  // namespace
}  // namespace isochor
