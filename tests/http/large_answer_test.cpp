#include "server/http/large_answer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <thread>

namespace isochor {
namespace {

constexpr std::size_t piece_bytes = 60000;
constexpr int pieces = 40;

std::string piece(int number) {
  return std::string(piece_bytes, static_cast<char>('a' + number % 26));
}

std::string all_pieces() {
  std::string all;
  for (int i = 0; i < pieces; ++i) all += piece(i);
  return all;
}

/// As a reader gets it.
std::string taken(const Response& response) {
  if (!response.file) return *response.body;
  int ends[2];
  EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  std::thread sender([&] {
    std::size_t sent = 0;
    while (sent < response.file->size()) {
      const ssize_t more = response.file->send(ends[0], sent);
      if (more <= 0) break;
      sent += static_cast<std::size_t>(more);
    }
    close(ends[0]);
  });
  std::string text, buffer(1 << 16, '\0');
  for (ssize_t got = 0; (got = read(ends[1], buffer.data(), buffer.size())) > 0;)
    text.append(buffer, 0, static_cast<std::size_t>(got));
  sender.join();
  close(ends[1]);
  return text;
}

class Answers : public testing::Test {
 protected:
  std::shared_ptr<LargeAnswer> answer() {
    auto made = std::make_shared<LargeAnswer>(disposal_);
    for (int i = 0; i < pieces; ++i) made->append(piece(i));
    return made;
  }

 private:
  Disposal disposal_;
};

TEST_F(Answers, AreInAFileWhereTheyAreLarge) {
  const auto large = answer();
  const Response response = large->respond(large);
  ASSERT_TRUE(response.file);
  EXPECT_EQ(response.body_size(), piece_bytes * pieces);
  EXPECT_EQ(taken(response), all_pieces());
}

TEST_F(Answers, CanBeCorrectedWhereverTheyAre) {
  Disposal disposal;
  for (const std::size_t size : {std::size_t{1000}, LargeAnswer::most_in_memory + 1}) {
    const auto changed = std::make_shared<LargeAnswer>(disposal);
    changed->append(std::string(size, 'a'));
    changed->overwrite(10, "bcd");
    std::string expected(size, 'a');
    expected.replace(10, 3, "bcd");
    EXPECT_EQ(taken(changed->respond(changed)), expected) << size;
  }
}

TEST_F(Answers, StayInMemoryWhereThereIsNoFolder) {
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/nonexistent", 1);
  const auto large = answer();
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  const Response response = large->respond(large);
  EXPECT_FALSE(response.file);
  EXPECT_EQ(taken(response), all_pieces());
}

TEST_F(Answers, GoBackToMemoryWhereTheDiskFillsUp) {
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  getrlimit(RLIMIT_FSIZE, &old);
  for (const rlim_t room :
       {1000UL, 1000000UL}) {  // not even what came so far, and later in the middle of a piece
    const rlimit narrow{room, old.rlim_max};
    setrlimit(RLIMIT_FSIZE, &narrow);
    const auto large = answer();
    setrlimit(RLIMIT_FSIZE, &old);
    const Response response = large->respond(large);
    EXPECT_FALSE(response.file);
    EXPECT_EQ(taken(response), all_pieces()) << room;
  }
  std::signal(SIGXFSZ, old_handler);
}

}  // namespace
}  // namespace isochor
