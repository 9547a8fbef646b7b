#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/export/atomic_file.h"
#include "core/report/stability.h"
#include "server/cli/commands.h"
#include "server/cli/data_folder.h"
#include "server/messages/report_messages.h"
#include "server/problem.h"
#include "server/report/report_page.h"

namespace isochor {
namespace {

struct StabilityCommand {
  bool full = false;
  std::string html;
};

std::string ratio(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

void run_suite(CliContext& context, const StabilityCommand& command) {
  constexpr const char* columns = "{:<4} {:<34} {:>5} {:>7} {:>5}  {}";
  context.print("k in N/m, h in s. Largest relative volume error of a cell; largest energy, 1 at the start,");
  context.print("against what motion, springs and gravity have given; inverted tets at the end.");
  std::string group;
  const auto print = [&](const StabilityResult& r) {
    if (context.json) context.note(fmt::format("{} {}: {}", r.passed ? "ok" : "FAIL", r.name, r.outcome));
    if (r.group != group) context.print(fmt::format(columns, "", "", "cell", "energy", "tets", ""));
    if (r.group != group)
      context.print(fmt::format(columns, "", r.group, "error", "ratio", "inv.", "outcome"));
    group = r.group;
    context.print(fmt::format(columns, r.passed ? "ok" : "FAIL", r.name,
                              fmt::format("{:.0e}", r.max_cell_volume_error), ratio(r.energy_ratio),
                              r.inverted, r.outcome));
  };
  StabilityReport report;
  {
    CommandProgress progress(context);
    report = run_stability(command.full ? StabilityExtent::full : StabilityExtent::quick, progress, print);
  }
  const std::string json = encode_stability(report);
  if (!command.html.empty()) write_file(command.html, make_report_page(json, data_folder("web")));
  if (context.json) context.print_json(Json::parse(json));
  // The table is the one document, so a shortfall is an exit code and a sentence, not a second document.
  const auto failed = std::ranges::count_if(report.results, [](const auto& r) { return !r.passed; });
  if (!report.complete)
    context.exit_code = exit_interrupted;
  else if (failed > 0)
    context.exit_code = exit_quality;
  context.print(fmt::format("{} of {} cases hold{}", report.results.size() - failed, report.results.size(),
                            report.complete ? "" : "; interrupted before the end"));
}

}  // namespace

void add_stability_command(CLI::App& app, CliContext& context) {
  CLI::App* command =
      add_command(app, context, "stability", "Run the stiff and extreme cases and judge each one");
  const auto options = std::make_shared<StabilityCommand>();
  command->add_flag("--full", options->full, "The whole map of stiffness and step, and a million cells");
  command->add_option("--html", options->html, "Write the table as a page");
  command->callback(
      [&context, options] { context.run = [&context, options] { run_suite(context, *options); }; });
}

}  // namespace isochor
