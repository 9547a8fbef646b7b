#include "server/cli/cli.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <new>
#include <string_view>

#include "server/build_info.h"
#include "server/cli/commands.h"
#include "server/memory_reserve.h"
#include "server/messages/problem_messages.h"
#include "server/problem.h"

namespace isochor {
namespace {

/// CLI11 leaves long descriptions on one line.
class WrappingFormatter : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    constexpr std::size_t width = 76;
    std::string text = CLI::Formatter::make_option_desc(option);
    std::size_t line = 0, space = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == ' ') space = i;
      if (i - line < width || space <= line) continue;
      text[space] = '\n';
      line = space + 1;
    }
    return text;
  }
};

bool wants_json(int argc, char** argv) {
  return std::any_of(argv + 1, argv + argc, [](std::string_view word) { return word == "--json"; });
}

/// One sentence and what to do next on stderr; with --json the problem document on stdout.
int report(const Error& error, bool json) {
  std::fputs(fmt::format("error: {}\n", error.what()).c_str(), stderr);
  if (!error.hint().empty()) std::fputs(fmt::format("hint: {}\n", error.hint()).c_str(), stderr);
  if (json) std::fputs((encode_problem(error) + "\n").c_str(), stdout);
  return problem_mapping(error.code()).exit_code;
}

int report_usage(const CLI::App& app, const CLI::ParseError& error, bool json) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  std::string command = "isochor ";
  for (const CLI::App* named : app.get_subcommands()) command += named->get_name() + " ";
  return report(Error(ErrorCode::invalid_argument, error.what(), "see " + command + "--help"), json);
}

int run(CLI::App& app, CliContext& context, int argc, char** argv) {
  const bool json = wants_json(argc, argv);
  if (argc < 2) std::fputs(app.help().c_str(), stderr);
  try {
    app.parse(argc, argv);
    context.run();
    return context.exit_code;
  } catch (const CLI::ParseError& error) {
    return report_usage(app, error, json);
  } catch (const Error& error) {
    return report(error, json);
  } catch (const std::bad_alloc&) {
    return report(Error(ErrorCode::over_budget, "out of memory", "lower voxels or cells"), json);
  } catch (const std::exception& error) {
    return report(Error(ErrorCode::internal, error.what()), json);
  }
}

}  // namespace

int run_cli(int argc, char** argv) try {
  keep_memory_reserve();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk: writing says so
  CLI::App app{"Tetrahedral models from any triangle mesh, simulated at constant volume", "isochor"};
  app.set_version_flag("--version", "isochor " + build_info().version);
  app.require_subcommand(1);
  app.formatter(std::make_shared<WrappingFormatter>());
  app.get_formatter()->column_width(34);
  CliContext context;
  add_serve_command(app, context);
  add_mesh_command(app, context);
  add_simulate_command(app, context);
  add_report_command(app, context);
  add_stability_command(app, context);
  add_info_command(app, context);
  add_formats_command(app, context);
  add_generate_command(app, context);
  return run(app, context, argc, argv);
} catch (const std::bad_alloc&) {
  // Not even enough memory to say it properly.
  constexpr std::string_view text = "error: out of memory\nhint: lower voxels or cells\n";
  return ::write(STDERR_FILENO, text.data(), text.size()) < 0 ? exit_internal : exit_budget;
}

}  // namespace isochor
