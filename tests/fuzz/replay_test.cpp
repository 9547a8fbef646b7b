#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/targets.h"

namespace isochor {
namespace {

class Replay : public testing::TestWithParam<const char*> {};

// Every seed, every case found so far, and each of them cut short or with one byte changed.
TEST_P(Replay, EndsInAResultOrANamedError) {
  int cases = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(ISOCHOR_CORPUS) / GetParam())) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    fuzz_reader(GetParam(), bytes);
    for (std::size_t length = 0; length < bytes.size(); ++length)
      fuzz_reader(GetParam(), std::string_view(bytes).substr(0, length));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const char original = bytes[i];
      for (const char changed : {'\0', '-', '9', '\xff'}) {
        bytes[i] = changed;
        fuzz_reader(GetParam(), bytes);
      }
      bytes[i] = original;
    }
    ++cases;
  }
  EXPECT_GT(cases, 0);
}

INSTANTIATE_TEST_SUITE_P(Readers, Replay,
                         testing::Values("obj", "stl", "ply", "off", "glb", "scene", "params", "http"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace isochor
