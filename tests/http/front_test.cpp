#include "server/http/front.h"

#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "tests/support/http_client.h"

namespace isochor {
namespace {

using test::RawSocket;

Route immediate(std::string_view pattern, std::function<void()> act) {
  return {.method = "GET",
          .pattern = pattern,
          .operation = "get",
          .summary = "",
          .handler =
              [act](const Request&) {
                act();
                return Response::json("{}");
              },
          .answers = {},
          .immediate = true};
}

/// A front whose thread can be held up, as a program that is not scheduled.
class HeldUp : public testing::Test {
 protected:
  HeldUp() {
    thread_ = std::thread([this] { front_.run(); });
  }
  ~HeldUp() override {
    front_.stop();
    thread_.join();
  }

  RawSocket ask(const std::string& path) const {
    RawSocket socket(listener_.port());
    socket.send("GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(listener_.port()) +
                "\r\n\r\n");
    return socket;
  }

  std::promise<void> reached_, let_go_;
  int answered_ = 0, answered_before_ = -1;  ///< of the many, and of them before /last
  Listener listener_{"127.0.0.1", 0};
  Service service_{{immediate("/hold",
                              [this] {
                                reached_.set_value();
                                let_go_.get_future().wait();
                              }),
                    immediate("/many",
                              [this] {
                                // A part of what is handled at a time; longer where the machine is slow.
                                std::this_thread::sleep_for(std::chrono::microseconds(200));
                                ++answered_;
                              }),
                    immediate("/last", [this] { answered_before_ = answered_; })},
                   loopback_policy(listener_.port(), "t")};
  Workers workers_;
  Front front_{listener_, service_, workers_, std::make_shared<Waker>()};
  std::thread thread_;
};

TEST_F(HeldUp, WhoAsksDoesNotWaitForThoseWhoComeLater) {
  constexpr int before = 50, later = 800;
  RawSocket held = ask("/hold");
  reached_.get_future().wait();
  std::vector<RawSocket> many;
  for (int i = 0; i < before; ++i) many.push_back(ask("/many"));
  RawSocket last = ask("/last");
  for (int i = 0; i < later; ++i) many.push_back(ask("/many"));
  let_go_.set_value();
  EXPECT_EQ(test::parse_response(last.receive_all()).status, 200);
  EXPECT_EQ(answered_before_, before);
  for (RawSocket& socket : many)  // nor are they forgotten
    EXPECT_EQ(test::parse_response(socket.receive_all()).status, 200);
}

}  // namespace
}  // namespace isochor
