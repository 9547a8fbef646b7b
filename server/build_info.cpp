#include "server/build_info.h"

#include <fmt/format.h>

#include <fstream>
#include <thread>

namespace isochor {
namespace {

#ifdef __clang__
constexpr const char* compiler = "Clang " __clang_version__;
#else
constexpr const char* compiler = "GCC " __VERSION__;
#endif

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return "unknown CPU";
}

}  // namespace

const BuildInfo& build_info() {
  static const BuildInfo info{ISOCHOR_VERSION, ISOCHOR_COMMIT, compiler,
                              fmt::format("{}, {} cores", cpu_model(), std::thread::hardware_concurrency())};
  return info;
}

}  // namespace isochor
