#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "server/cli/commands.h"

namespace isochor {
namespace {

/// roff takes a leading dot and every backslash for its own, and a hyphen for a break.
std::string roff(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\' || c == '-') escaped += '\\';
    if ((c == '.' || c == '\'') && (escaped.empty() || escaped.back() == '\n')) escaped += "\\&";
    escaped += c;
  }
  return escaped;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string options_of(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    const std::string value = option->get_type_size() > 0 && !option->get_positional()
                                  ? fmt::format(" \\fI{}\\fR", roff(option->get_type_name()))
                                  : "";
    std::string fallback = option->get_default_str();
    if (!fallback.empty()) fallback = fmt::format(" Default: {}.", fallback);
    text += fmt::format(".TP\n\\fB{}\\fR{}\n{}{}\n", roff(option->get_name(false, true)), value,
                        roff(option->get_description()), roff(fallback));
  }
  return text;
}

std::string exit_codes() {
  return ".SH EXIT STATUS\n0 success; 1 internal error, or a target that cannot be written; 2 usage; 3 input "
         "cannot be read; 4 unsupported format; 5 empty, degenerate or incomplete result; 6 a quality gate "
         "failed; "
         "7 out of budget; 8 port in use; 130 interrupted.\n";
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH ISOCHOR 1 \"\" \"{}\" \"User Commands\"\n.SH NAME\nisochor \\- {}\n.SH SYNOPSIS\n\\fBisochor\\fR "
      "\\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n",
      app.version(), roff(app.get_description()));
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App* c) { return !c->get_group().empty(); }))
    text += fmt::format(".SH {}\n{}.\n{}", upper(command->get_name()), roff(command->get_description()),
                        options_of(*command));
  return text + exit_codes();
}

}  // namespace isochor
