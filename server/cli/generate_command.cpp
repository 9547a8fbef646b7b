#include "server/cli/commands.h"

namespace isochor {

void add_generate_command(CLI::App& app, CliContext& context) {
  CLI::App* command = app.add_subcommand("generate", "Write the man page or the shell completion");
  command->group("");  // not in --help
  const auto what = std::make_shared<std::string>();
  command->add_option("WHAT", *what)->required()->check(CLI::IsMember({"man", "bash-completion"}));
  command->callback([&app, &context, what] {
    context.run = [&app, what] {
      std::fputs((*what == "man" ? man_page(app) : bash_completion(app)).c_str(), stdout);
    };
  });
}

}  // namespace isochor
