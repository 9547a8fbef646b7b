#include "tests/bench/run_apart.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <stdexcept>

#include "tests/bench/cpu_clock.h"

namespace isochor {
namespace {

template <class T>
void put(std::FILE* pipe, const std::vector<T>& values) {
  const std::size_t count = values.size();
  std::fwrite(&count, sizeof count, 1, pipe);
  std::fwrite(values.data(), sizeof(T), count, pipe);
}

template <class T>
bool get(std::FILE* pipe, std::vector<T>& values) {
  std::size_t count = 0;
  if (std::fread(&count, sizeof count, 1, pipe) != 1) return false;
  values.resize(count);
  return std::fread(values.data(), sizeof(T), count, pipe) == count;
}

[[noreturn]] void work(const std::function<Tets()>& mesher, int descriptor, int seconds_allowed) {
  const rlimit limit{static_cast<rlim_t>(seconds_allowed), RLIM_INFINITY};
  ::setrlimit(RLIMIT_CPU, &limit);
  Tets mesh;
  std::string failure;
  const double start = cpu_seconds();
  try {
    mesh = mesher();
    if (mesh.tets.empty()) failure = "gave no tets";
  } catch (const std::exception& error) {
    failure = error.what();
  }
  const std::vector<double> seconds{cpu_seconds() - start};
  std::FILE* pipe = ::fdopen(descriptor, "wb");
  put(pipe, std::vector<char>(failure.begin(), failure.end()));
  put(pipe, seconds);
  put(pipe, mesh.positions);
  put(pipe, mesh.tets);
  std::fclose(pipe);
  std::_Exit(0);
}

std::string end_of(int status, int seconds_allowed) {
  if (!WIFSIGNALED(status)) return fmt::format("ended with exit code {}", WEXITSTATUS(status));
  return WTERMSIG(status) == SIGXCPU ? fmt::format("nothing within {} s", seconds_allowed)
                                     : fmt::format("crashed (signal {})", WTERMSIG(status));
}

}  // namespace

Apart run_apart(const std::function<Tets()>& mesher, int seconds_allowed) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    work(mesher, ends[1], seconds_allowed);
  }
  ::close(ends[1]);
  std::FILE* pipe = ::fdopen(ends[0], "rb");
  Apart result;
  std::vector<char> failure;
  std::vector<double> seconds;
  const bool whole = get(pipe, failure) && get(pipe, seconds) && get(pipe, result.mesh.positions) &&
                     get(pipe, result.mesh.tets);
  std::fclose(pipe);
  int status = 0;
  ::waitpid(child, &status, 0);
  result.failure = whole ? std::string(failure.begin(), failure.end()) : end_of(status, seconds_allowed);
  if (whole) result.seconds = seconds.front();
  return result;
}

}  // namespace isochor
