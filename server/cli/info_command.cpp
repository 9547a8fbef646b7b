#include <fmt/format.h>

#include "core/mesh_input/inspect.h"
#include "server/cli/commands.h"
#include "server/cli/input.h"
#include "server/messages/model_messages.h"

namespace isochor {
namespace {

std::string text_of(const MeshReport& report) {
  const Vec3 size = report.bounds.size();
  std::string text = fmt::format(
      "{} triangles, {} vertices, {} component{}, {}\n"
      "box {:.6g} × {:.6g} × {:.6g}, area {:.6g}",
      report.triangles, report.vertices, report.components, report.components == 1 ? "" : "s",
      report.closed ? "closed" : "not closed", size.x(), size.y(), size.z(), report.area);
  if (report.closed) text += fmt::format(", volume {:.6g}", report.volume);
  text += '\n';
  for (const Defect& defect : report.defects)
    if (defect.count > 0) text += fmt::format("  {:<28} {}\n", defect.name, defect.count);
  return text;
}

void run_info(const CliContext& context, const InputOptions& options) {
  CommandProgress progress(context);
  const InputMesh input = read_input(options, progress);
  const MeshReport report = inspect(*input.soup);
  if (context.json)
    context.print_json({{"input", options.path},
                        {"bytes", input.bytes},
                        {"read_ms", input.read_ms},
                        {"report", mesh_report_json(report)}});
  else
    std::fputs(text_of(report).c_str(), stdout);
}

}  // namespace

void add_info_command(CLI::App& app, CliContext& context) {
  CLI::App* command = add_command(app, context, "info", "Count and locate what is in a triangle mesh");
  const auto options = std::make_shared<InputOptions>();
  add_input_options(*command, *options);
  command->callback(
      [&context, options] { context.run = [&context, options] { run_info(context, *options); }; });
}

}  // namespace isochor
