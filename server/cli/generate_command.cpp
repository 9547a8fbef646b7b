#include <map>

#include "server/cli/commands.h"

namespace isochor {

void add_generate_command(CLI::App& app, CliContext& context) {
  static const std::map<std::string, std::string (*)(const CLI::App&)> writers{
      {"man", man_page}, {"bash-completion", bash_completion}, {"zsh-completion", zsh_completion}};
  CLI::App* command = app.add_subcommand("generate", "Write the man page or a shell's completion");
  command->group("");  // not in --help
  const auto what = std::make_shared<std::string>();
  command->add_option("WHAT", *what)->required()->check(CLI::IsMember(&writers));
  command->callback([&app, &context, what] {
    context.run = [&app, what] { std::fputs(writers.at(*what)(app).c_str(), stdout); };
  });
}

}  // namespace isochor
