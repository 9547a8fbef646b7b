#include "server/cli/context.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void interrupt(int signal) {
  // A second one ends a program that does not listen.
  if (interrupted.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

bool on_terminal() {
  return ::isatty(STDERR_FILENO) == 1;
}

/// A progress bar may stand there.
void clear_line() {
  if (on_terminal()) std::fputs("\r\033[K", stderr);
}

void print_line(const std::string& text) {
  clear_line();
  std::fputs((text + "\n").c_str(), stderr);
}

/// Not more digits than an estimate has.
std::string about(double seconds) {
  if (seconds < 10.0) return fmt::format("about {} s", std::max(1.0, std::round(seconds)));
  if (seconds < 90.0) return fmt::format("about {} s", 5.0 * std::round(seconds / 5.0));
  const double minutes = seconds / 60.0;
  if (minutes < 10.0) return fmt::format("about {} min", std::round(minutes));
  if (minutes < 90.0) return fmt::format("about {} min", 5.0 * std::round(minutes / 5.0));
  return fmt::format("about {:.2g} h", 0.5 * std::round(minutes / 30.0));
}

}  // namespace

void CliContext::print_json(const Json& document) const {
  std::fputs((to_text(document, 2) + "\n").c_str(), stdout);
  std::fflush(stdout);
}

void CliContext::print(const std::string& line) const {
  if (quiet || json) return;
  clear_line();
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);
}

void CliContext::note(const std::string& line) const {
  if (!quiet) print_line(line);
}

void CliContext::detail(const std::string& line) const {
  if (verbose && !quiet) print_line(line);
}

void CliContext::warning(const std::string& line) const {
  if (!quiet) print_line("warning: " + line);
}

CLI::App* add_command(CLI::App& app, CliContext& context, const std::string& name,
                      const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description);
  command->add_flag("--json", context.json, "Print exactly one JSON document on stdout");
  command->add_option("--threads", context.threads, "Threads to use; 0 is one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_flag("-q,--quiet", context.quiet, "Print errors only");
  command->add_flag("-v,--verbose", context.verbose, "Print more");
  return command;
}

CommandProgress::CommandProgress(const CliContext& context)
    : quiet_(context.quiet),
      terminal_(on_terminal()),
      progress_([this](std::string_view phase, double fraction) { show(phase, fraction); }, &interrupted) {
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  set_thread_count(context.threads);
}

CommandProgress::~CommandProgress() {
  if (!quiet_ && drawn_percent_ >= 0) clear_line();
}

void CommandProgress::show(std::string_view phase, double fraction) {
  if (quiet_) return;
  if (terminal_) return draw(phase, fraction);
  const std::string left = time_left(fraction);
  if (phase != phase_) print_line(std::string(phase) + left);
  phase_ = phase;
}

std::string CommandProgress::time_left(double fraction) {
  const Clock::time_point now = Clock::now();
  if (fraction < 0.5 * last_fraction_) start_ = now, start_fraction_ = fraction;  // another phase
  last_fraction_ = fraction;
  const double elapsed = std::chrono::duration<double>(now - start_).count(),
               done = fraction - start_fraction_;
  if (elapsed < 1.0 || done < 0.01) return {};
  return ", " + about(elapsed * (1.0 - fraction) / done) + " left";
}

void CommandProgress::draw(std::string_view phase, double fraction) {
  constexpr int width = 40;
  const int percent = static_cast<int>(100.0 * fraction);
  const std::string left = time_left(fraction);
  if (phase == phase_ && percent == drawn_percent_) return;
  phase_ = phase;
  drawn_percent_ = percent;
  const int filled = std::clamp(static_cast<int>(width * fraction), 0, width);
  std::fputs(fmt::format("\r\033[K[{:#<{}}{:.<{}}] {:3d} % {}{}", "", filled, "", width - filled, percent,
                         phase, left)
                 .c_str(),
             stderr);
  std::fflush(stderr);
}

}  // namespace isochor
