#include <fmt/format.h>

#include "server/cli/commands.h"

namespace isochor {
namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::string long_options(const CLI::App& command) {
  std::string words;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) words += (words.empty() ? "--" : " --") + name;
  return words;
}

/// For zsh, within single quotes: in `--name[what it does]` and `name:what it does` a colon or bracket of the
/// text would end it.
std::string zsh_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'')
      escaped += "'\\'";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      escaped += '\\';
    escaped += c;
  }
  return escaped;
}

/// What _arguments asks of each option: `=` takes its value after a space or an equals sign.
std::string zsh_options(const CLI::App& command) {
  std::string specs;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      specs += fmt::format(
          " \\\n      '--{}{}[{}]{}'", name, option->get_type_size() > 0 ? "=" : "",
          zsh_text(option->get_description()),
          option->get_type_size() > 0 ? fmt::format(":{}:_files", zsh_text(option->get_type_name())) : "");
  return specs;
}

}  // namespace

// Options of the command that was named; for everything else the shell's own file names.
std::string bash_completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(app)) {
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

// As bash_completion, with what each command and option does beside it.
std::string zsh_completion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : commands_of(app)) {
    commands += fmt::format("    '{}:{}'\n", command->get_name(), zsh_text(command->get_description()));
    cases += fmt::format("    {}) _arguments{} \\\n      '*:file:_files' ;;\n", command->get_name(),
                         zsh_options(*command));
  }
  return fmt::format(
      "#compdef isochor\n"
      "# zsh completion for isochor, written by: isochor generate zsh-completion\n"
      "local -a commands=(\n{}  )\n"
      "if (( CURRENT == 2 )); then\n"
      "  _describe command commands\n"
      "  return\n"
      "fi\n"
      "shift words\n"
      "(( CURRENT-- ))\n"
      "case $words[1] in\n{}"
      "esac\n",
      commands, cases);
}

}  // namespace isochor
