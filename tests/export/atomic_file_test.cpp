#include "core/export/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "core/common/error.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

class AtomicFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("atomic_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::ptrdiff_t entries() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }
  fs::path folder_;
};

TEST_F(AtomicFiles, ReplaceTheirTargetAndKeepItsMode) {
  write_file(folder_ / "a", "one");
  fs::permissions(folder_ / "a", fs::perms::owner_read | fs::perms::owner_write);
  write_file(folder_ / "a", "two");
  EXPECT_EQ(read("a"), "two");
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFiles, LeaveNothingWithoutACommit) {
  write_file(folder_ / "a", "old");
  {
    AtomicFile file(folder_ / "a");
    file.write("half of the n");
    EXPECT_EQ(read("a"), "old");
    EXPECT_EQ(entries(), 2);
  }
  EXPECT_EQ(read("a"), "old");
  EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFiles, AreRemovedOnceTheirProgramIsGone) {
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  ::waitpid(gone, nullptr, 0);
  for (const std::string& name : {".a.json." + std::to_string(gone) + ".0.tmp", std::string(".other.tmp")})
    std::ofstream(folder_ / name) << "half";
  AtomicFile of_this_program(folder_ / "a");
  EXPECT_EQ(entries(), 3);
  remove_abandoned(folder_);
  EXPECT_EQ(entries(), 2);
  of_this_program.commit();
  EXPECT_TRUE(fs::exists(folder_ / "a"));
  EXPECT_TRUE(fs::exists(folder_ / ".other.tmp"));
}

TEST_F(AtomicFiles, KeepASymbolicLink) {
  write_file(folder_ / "a", "old");
  fs::create_symlink("a", folder_ / "link");
  write_file(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read("a"), "new");
}

TEST_F(AtomicFiles, WriteStraightThroughToADevice) {
  EXPECT_NO_THROW(write_file("/dev/null", "anything"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

void expect_cannot_write(const fs::path& path, std::string_view content) {
  try {
    write_file(path, content);
    FAIL() << path;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cannot_write);
    EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos);
    EXPECT_FALSE(error.hint().empty());
  }
}

TEST_F(AtomicFiles, NameATargetThatCannotBeWritten) {
  expect_cannot_write(folder_ / "missing" / "a", "x");
  expect_cannot_write(folder_, "x");
  expect_cannot_write("/dev/full", "x");
}

TEST_F(AtomicFiles, AFullDiskLosesNothingAndLeavesNothing) {
  write_file(folder_ / "a", "old");
  // A limit on file size stands for the disk: write(2) fails half-way in the same manner.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  expect_cannot_write(folder_ / "a", std::string(4000, 'x'));
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(read("a"), "old");
  EXPECT_EQ(entries(), 1);
}

TEST_F(AtomicFiles, OfASetNoneIsWrittenWhenOneFails) {
  write_file(folder_ / "a", "old");
  const std::vector<NamedContent> files{{folder_ / "a", "new"}, {folder_ / "missing" / "b", "new"}};
  EXPECT_THROW(write_files(files), Error);
  EXPECT_EQ(read("a"), "old");
  EXPECT_EQ(entries(), 1);
}

}  // namespace
}  // namespace isochor
