#include <fmt/format.h>

#include "server/cli/commands.h"

namespace isochor {
namespace {

std::string long_options(const CLI::App& command) {
  std::string words;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) words += (words.empty() ? "--" : " --") + name;
  return words;
}

}  // namespace

// Options of the command that was named; for everything else the shell's own file names.
std::string bash_completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); })) {
    commands += (commands.empty() ? "" : " ") + command->get_name();
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command->get_name(), long_options(*command));
  }
  return fmt::format(
      "# bash completion for isochor, written by: isochor generate bash-completion\n"
      "_isochor() {{\n"
      "  local words current=${{COMP_WORDS[COMP_CWORD]}}\n"
      "  case $COMP_CWORD:${{COMP_WORDS[1]}} in\n"
      "    1:*) COMPREPLY=($(compgen -W \"{} --help --version\" -- \"$current\")); return ;;\n"
      "  esac\n"
      "  case ${{COMP_WORDS[1]}} in\n{}"
      "  esac\n"
      "  case $current in\n"
      "    -*) COMPREPLY=($(compgen -W \"$words\" -- \"$current\")) ;;\n"
      "    *) COMPREPLY=() ;;\n"
      "  esac\n"
      "}}\n"
      "complete -o default -F _isochor isochor\n",
      commands, cases);
}

}  // namespace isochor
