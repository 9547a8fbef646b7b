#pragma once
#include <CLI/CLI.hpp>
#include <chrono>
#include <functional>
#include <string>

#include "core/common/progress.h"
#include "server/messages/json.h"

namespace isochor {

/// What all commands share. Data goes to stdout, everything else to stderr.
struct CliContext {
  bool json = false;   ///< exactly one JSON document on stdout
  bool quiet = false;  ///< errors only
  bool verbose = false;
  int threads = 0;  ///< 0: one a core
  int exit_code = 0;
  /// Runs after all arguments have been read; set by the command that was named.
  std::function<void()> run;

  void print_json(const Json& document) const;
  void print(const std::string& line) const;    ///< data for a person: unless quiet or --json
  void note(const std::string& line) const;     ///< unless quiet
  void detail(const std::string& line) const;   ///< with -v
  void warning(const std::string& line) const;  ///< unless quiet
};

/// Adds a command with the options that all have: --json, --threads, -q, -v.
CLI::App* add_command(CLI::App& app, CliContext& context, const std::string& name,
                      const std::string& description);

/// Long work of a command: a bar with an estimate of the time left on a terminal, else a line a phase; Ctrl-C
/// and SIGTERM cancel it.
class CommandProgress {
 public:
  explicit CommandProgress(const CliContext& context);
  ~CommandProgress();  ///< clears the bar
  CommandProgress(const CommandProgress&) = delete;
  CommandProgress& operator=(const CommandProgress&) = delete;
  operator Progress&() { return progress_; }

 private:
  void show(std::string_view phase, double fraction);
  void draw(std::string_view phase, double fraction);

  /// Of what the fraction counts, as long as it rises; empty while it is too early to tell.
  std::string time_left(double fraction);

  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_;
  std::string phase_;
  int drawn_percent_ = -1;
  Clock::time_point start_ = Clock::now();
  double start_fraction_ = 0.0, last_fraction_ = 0.0;
  Progress progress_;
};

}  // namespace isochor
