#include <fmt/format.h>

#include "core/export/export.h"
#include "server/cli/commands.h"
#include "server/messages/model_messages.h"

namespace isochor {
namespace {

constexpr const char* input_formats = "obj stl ply off glb";

void run_formats(const CliContext& context) {
  if (context.json) {
    context.print_json({{"input", {"obj", "stl", "ply", "off", "glb"}}, {"export", export_formats_json()}});
    return;
  }
  std::string text = fmt::format("read    {}\n", input_formats);
  for (const ExportFormat& format : export_formats())
    text += fmt::format("write   {:<10} {:<16} {}\n        {:<10} {}\n", format.name, format.extension,
                        format.consumers, "", format.conventions);
  std::fputs(text.c_str(), stdout);
}

}  // namespace

void add_formats_command(CLI::App& app, CliContext& context) {
  CLI::App* command = add_command(app, context, "formats", "List the formats that are read and written");
  command->callback([&context] { context.run = [&context] { run_formats(context); }; });
}

}  // namespace isochor
